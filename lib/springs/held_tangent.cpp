#include "springs/held_tangent.h"

namespace tissue {
namespace {

using Factor = Eigen::SimplicialLDLT<SparseMatrix>;

Definiteness factorise(Factor& factor, const SparseMatrix& K) {
    constexpr double rounding = 1e-10;
    factor.compute(K);
    if (factor.info() != Eigen::Success) return Definiteness::flat;  // the factorisation stops at a pivot of zero
    const Eigen::VectorXd pivots = factor.vectorD();
    const double largest = pivots.cwiseAbs().maxCoeff();
    for (double pivot : pivots)
        if (!(pivot > rounding * largest)) return pivot < -rounding * largest ? Definiteness::negative : Definiteness::flat;
    return Definiteness::positive;
}

}  // namespace

FreeNumbering::FreeNumbering(const SpringMesh& mesh) {
    const int D = mesh.dimension();
    number.assign(static_cast<std::size_t>(D * mesh.node_count()), 0);
    for (int node : mesh.fixed)
        for (int d = 0; d < D; ++d) number[static_cast<std::size_t>(D * node + d)] = -1;
    for (int& n : number)
        if (n >= 0) n = count++;
}

Eigen::VectorXd FreeNumbering::gather(const Eigen::VectorXd& nodal) const {
    Eigen::VectorXd free(count);
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] >= 0) free[number[i]] = nodal[static_cast<Eigen::Index>(i)];
    return free;
}

void FreeNumbering::add(const Eigen::VectorXd& free, NodeField& nodal) const {
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] >= 0) nodal.data()[i] += free[number[i]];
}

Eigen::MatrixXd FreeNumbering::scatter_columns(const Eigen::MatrixXd& free) const {
    Eigen::MatrixXd nodal = Eigen::MatrixXd::Zero(free.rows(), static_cast<Eigen::Index>(number.size()));
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] >= 0) nodal.col(static_cast<Eigen::Index>(i)) = free.col(number[i]);
    return nodal;
}

FreeTangent::FreeTangent(const SparseMatrix& stiffness, const FreeNumbering& numbering)
    : K(numbering.count, numbering.count) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(stiffness.nonZeros()));
    for (int column = 0; column < stiffness.outerSize(); ++column)
        for (SparseMatrix::InnerIterator it(stiffness, column); it; ++it) {
            const int i = numbering.number[static_cast<std::size_t>(it.row())],
                      j = numbering.number[static_cast<std::size_t>(column)];
            if (i >= 0 && j >= 0) entries.emplace_back(i, j, it.value());
        }
    K.setFromTriplets(entries.begin(), entries.end());
    definiteness = factorise(factor, K);
}

/// Elimination of one degree of freedom per axis: that with the largest weight of the contact.
struct HeldTangent::Eliminated {
    SparseMatrix Z, Y;  // F x (F - D), F x D
    Factor factor;      // of Z'KZ + shift
    Definiteness definiteness;
};

HeldTangent::HeldTangent(const FreeTangent& free, const Eigen::MatrixXd& W, double shift) : free_(free), W_(W) {
    if (free.definiteness == Definiteness::positive && shift == 0) {
        KW_ = free.factor.solve(W);
        compliance_ = (W.transpose() * KW_).ldlt();
        return;
    }
    const Eigen::Index F = W.rows(), D = W.cols();
    std::vector<int> axis_of(static_cast<std::size_t>(F), -1);  // -1: remains a degree of freedom
    std::vector<Eigen::Triplet<double>> z, y;
    for (Eigen::Index d = 0; d < D; ++d) {
        Eigen::Index most = 0;
        W.col(d).cwiseAbs().maxCoeff(&most);
        axis_of[static_cast<std::size_t>(most)] = static_cast<int>(d);
        y.emplace_back(most, d, 1 / W(most, d));
    }
    Eigen::Index column = 0;
    for (Eigen::Index i = 0; i < F; ++i) {
        if (axis_of[static_cast<std::size_t>(i)] >= 0) continue;
        z.emplace_back(i, column, 1.0);
        for (const auto& held : y)
            if (W(i, held.col()) != 0) z.emplace_back(held.row(), column, -W(i, held.col()) * held.value());
        ++column;
    }
    auto e = std::make_shared<Eliminated>();
    e->Z.resize(F, F - D);
    e->Z.setFromTriplets(z.begin(), z.end());
    e->Y.resize(F, D);
    e->Y.setFromTriplets(y.begin(), y.end());
    SparseMatrix reduced = e->Z.transpose() * free.K * e->Z;
    for (Eigen::Index i = 0; i < F - D; ++i) reduced.coeffRef(i, i) += shift;
    // F = D: no displacement is left free
    e->definiteness = F > D ? factorise(e->factor, reduced) : Definiteness::positive;
    eliminated_ = std::move(e);
}

Definiteness HeldTangent::definiteness() const {
    return eliminated_ ? eliminated_->definiteness : Definiteness::positive;
}

HeldTangent::Step HeldTangent::solve(const Eigen::VectorXd& residual, const Eigen::VectorXd& gap) const {
    if (!eliminated_) {
        const Eigen::VectorXd Kr = free_.factor.solve(residual);
        const Eigen::VectorXd force = compliance_.solve(gap + W_.transpose() * Kr);
        return {KW_ * force - Kr, force};
    }
    const Eliminated& e = *eliminated_;
    Eigen::VectorXd du = e.Y * gap;
    if (e.Z.cols() > 0) du -= e.Z * e.factor.solve(Eigen::VectorXd(e.Z.transpose() * (residual + free_.K * du)));
    return {du, e.Y.transpose() * (residual + free_.K * du)};
}

Eigen::MatrixXd HeldTangent::sensitivity() const {
    if (!eliminated_) return compliance_.solve(KW_.transpose());
    const Eliminated& e = *eliminated_;
    Eigen::MatrixXd G = e.Y;
    if (e.Z.cols() > 0) G -= e.Z * e.factor.solve(Eigen::MatrixXd(e.Z.transpose() * (free_.K * G)));
    return G.transpose();
}

}  // namespace tissue
