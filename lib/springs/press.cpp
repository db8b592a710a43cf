#include "springs/press.h"

#include <algorithm>
#include <cmath>

#include "error.h"

namespace tissue {

const char* to_string(PressStatus status) {
    switch (status) {
        case PressStatus::held:
            return "held";
        case PressStatus::unstable:
            return "unstable";
        case PressStatus::inside_out:
            return "inside_out";
        case PressStatus::lost:
            return "lost";
    }
    return "unknown";
}

PressSolver::PressSolver(const TissueEnergy& energy, const ContactSurface& surface, const PressOptions& options)
    : energy_(energy), options_(options) {
    const int D = energy.dimension();
    const std::vector<int>& line = surface.outline().nodes();
    spacing_m_ = surface.outline().length() / static_cast<double>(line.size() - 1);

    number_.assign(static_cast<std::size_t>(D * energy.node_count()), 0);
    for (int node : energy.fixed())
        for (int d = 0; d < D; ++d) number_[static_cast<std::size_t>(D * node + d)] = -1;
    for (int& n : number_)
        if (n >= 0) n = free_++;

    // nodes that an element, or a contact anywhere on the surface, couples
    std::vector<Eigen::Triplet<double>> pattern;
    const auto couple = [&](int node, int other) {
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) {
                const int i = number_[static_cast<std::size_t>(D * node + a)], j = number_[static_cast<std::size_t>(D * other + b)];
                if (j >= 0 && i >= j) pattern.emplace_back(i, j, 0.0);
            }
    };
    for (const auto& kind : energy.kinds())
        for (int e = 0; e < kind->count(); ++e)
            for (Eigen::Index a = 0; a < kind->nodes().cols(); ++a)
                for (Eigen::Index b = 0; b < kind->nodes().cols(); ++b) couple(kind->nodes()(e, a), kind->nodes()(e, b));
    for (std::size_t i = 0; i < line.size(); ++i)
        for (std::size_t j = i; j < std::min(i + ContactPatch::size, line.size()); ++j) {
            couple(line[i], line[j]);
            couple(line[j], line[i]);
        }
    H_.resize(free_, free_);
    H_.setFromTriplets(pattern.begin(), pattern.end());
    H_.makeCompressed();
    factor_.analyzePattern(H_);

    for (const auto& kind : energy.kinds()) {
        std::vector<int>& slots = slots_.emplace_back();
        const Eigen::Index n = D * kind->nodes().cols();
        for (int e = 0; e < kind->count(); ++e)
            for (Eigen::Index a = 0; a < n; ++a)
                for (Eigen::Index b = 0; b < n; ++b) {
                    const auto dof = [&](Eigen::Index k) {
                        return number_[static_cast<std::size_t>(kind->nodes()(e, k / D) * D + k % D)];
                    };
                    const bool stored = dof(b) >= 0 && dof(a) >= dof(b);
                    slots.push_back(stored ? static_cast<int>(entry(dof(a), dof(b)) - H_.valuePtr()) : -1);
                }
    }
}

double* PressSolver::entry(int row, int column) {
    const int* begin = H_.innerIndexPtr() + H_.outerIndexPtr()[column];
    const int* end = H_.innerIndexPtr() + H_.outerIndexPtr()[column + 1];
    return H_.valuePtr() + (std::lower_bound(begin, end, row) - H_.innerIndexPtr());
}

/// max |g| over |F|, and g (free). At no push there is no force either: what a push of
/// 1e-4 of the nodes' spacing takes, then.
double PressSolver::out_of_balance(const Eigen::VectorXd& constants, const PatchSpring& contact,
                                   const Eigen::Vector2d& push_m, const NodeField& u, Eigen::VectorXd& g) const {
    NodeField f = energy_.force(constants, u);
    Eigen::Vector2d at[ContactPatch::size];
    gather(contact.patch, u, at);
    const PatchSpring::Load load = contact.load(push_m, at);
    for (int i = 0; i < ContactPatch::size; ++i) f.row(contact.patch.node[i]) += load.node_N[i].transpose();
    g.resize(free_);
    for (std::size_t i = 0; i < number_.size(); ++i)
        if (number_[i] >= 0) g[number_[i]] = f.data()[i];
    return g.lpNorm<Eigen::Infinity>() / (load.hand_N.norm() + 1e-4 * spacing_m_ * contact.gap_N_m.norm());
}

/// False when H has a pivot of zero.
bool PressSolver::factorise(const Eigen::VectorXd& constants, const PatchSpring& contact, const NodeField& u) {
    const int D = energy_.dimension();
    std::fill(H_.valuePtr(), H_.valuePtr() + H_.nonZeros(), 0.0);
    ElementMatrix unit;
    for (std::size_t k = 0; k < slots_.size(); ++k) {
        const Elements& kind = *energy_.kinds()[k];
        const int* slot = slots_[k].data();
        for (int e = 0; e < kind.count(); ++e) {
            kind.tangent(e, u, unit);
            const double constant = constants[energy_.first_of(k) + e];
            for (Eigen::Index a = 0; a < unit.rows(); ++a)
                for (Eigen::Index b = 0; b < unit.cols(); ++b, ++slot)
                    if (*slot >= 0) H_.valuePtr()[*slot] += constant * unit(a, b);
        }
    }
    for (int i = 0; i < ContactPatch::size; ++i)
        for (int j = 0; j < ContactPatch::size; ++j) {
            const Eigen::Matrix2d block = contact.tangent(i, j);
            for (int a = 0; a < D; ++a)
                for (int b = 0; b < D; ++b) {
                    const int row = number_[static_cast<std::size_t>(D * contact.patch.node[i] + a)],
                              column = number_[static_cast<std::size_t>(D * contact.patch.node[j] + b)];
                    if (column >= 0 && row >= column) *entry(row, column) += block(a, b);
                }
        }
    factor_.factorize(H_);
    return factor_.info() == Eigen::Success;
}

/// Newton at one push. Leaves u where it was when it does not get there.
bool PressSolver::balance(const Eigen::VectorXd& constants, const PatchSpring& contact, const Eigen::Vector2d& push_m,
                          NodeField& u, int& iterations) {
    NodeField trial = u;
    Eigen::VectorXd g;
    for (int iteration = 0; iteration <= options_.max_newton; ++iteration) {
        const double off = out_of_balance(constants, contact, push_m, trial, g);
        if (off <= options_.tolerance) {
            u = trial;
            return true;
        }
        if (!std::isfinite(off) || iteration == options_.max_newton || !factorise(constants, contact, trial)) return false;
        const Eigen::VectorXd step = factor_.solve(g);
        for (std::size_t i = 0; i < number_.size(); ++i)
            if (number_[i] >= 0) trial.data()[i] -= step[number_[i]];
        ++iterations;
    }
    return false;
}

PressState PressSolver::press(const Eigen::VectorXd& constants, const PatchSpring& contact, const Eigen::Vector2d& push_m,
                              const PressState* from) {
    const int D = energy_.dimension();
    if (std::all_of(contact.patch.node, contact.patch.node + ContactPatch::size,
                    [&](int node) { return number_[static_cast<std::size_t>(D * node)] < 0; }))
        throw MismatchError("the contact lies on the fixed edge");
    PressState state;
    state.displacement = from ? from->displacement : NodeField::Zero(energy_.node_count(), D);
    const Eigen::Vector2d start_m = from ? from->push_m : Eigen::Vector2d::Zero();
    const Eigen::Vector2d way_m = push_m - start_m;
    const double steps = std::max(1.0, std::ceil(way_m.norm() / (options_.load_step * spacing_m_) - 1e-9));
    double done = 0, step = 1 / steps;
    while (done < 1) {
        const double next = done + step > 1 - 1e-9 ? 1 : done + step;
        if (balance(constants, contact, start_m + next * way_m, state.displacement, state.newton)) {
            done = next;
        } else if ((step /= 2) < options_.smallest_step) {
            state.status = PressStatus::lost;
            break;
        }
    }
    state.push_m = start_m + done * way_m;
    Eigen::Vector2d at[ContactPatch::size];
    gather(contact.patch, state.displacement, at);
    const PatchSpring::Load load = contact.load(state.push_m, at);
    state.contact_force_N = load.hand_N;
    state.energy_J = energy_.energy(constants, state.displacement) + load.energy_J;
    const bool regular = factorise(constants, contact, state.displacement);
    if (state.status == PressStatus::held && !(regular && factor_.vectorD().minCoeff() > 0))
        state.status = PressStatus::unstable;
    else if (state.status == PressStatus::held && !(energy_.smallest_area_ratio(state.displacement) > 0))
        state.status = PressStatus::inside_out;
    u_ = state.displacement;
    push_m_ = state.push_m;
    contact_ = contact;
    return state;
}

PressDerivative PressSolver::derivative(const Eigen::MatrixXd& constants_by, const Eigen::MatrixXd& stiffness_by) const {
    const int D = energy_.dimension();
    const Eigen::Index P = constants_by.cols();
    // dg/dp: the elements' unit forces, and the contact's
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> g = Eigen::MatrixXd::Zero(free_, P);
    ElementVector unit;
    for (std::size_t k = 0; k < energy_.kinds().size(); ++k) {
        const Elements& kind = *energy_.kinds()[k];
        for (int e = 0; e < kind.count(); ++e) {
            kind.force(e, u_, unit);
            for (Eigen::Index a = 0; a < unit.size(); ++a) {
                const int row = number_[static_cast<std::size_t>(kind.nodes()(e, a / D) * D + a % D)];
                if (row >= 0) g.row(row) += unit[a] * constants_by.row(energy_.first_of(k) + e);
            }
        }
    }
    const ContactPatch& patch = contact_->patch;
    Eigen::Vector2d at[ContactPatch::size];
    gather(patch, u_, at);
    PressDerivative by{Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(number_.size()), P), Eigen::MatrixXd::Zero(D, P)};
    const PatchStiffness one[4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (int m = 0; m < 4; ++m) {
        const PatchSpring::Load load = PatchSpring(patch, one[m]).load(push_m_, at);
        by.contact_force += load.hand_N * stiffness_by.row(m);
        for (int i = 0; i < ContactPatch::size; ++i)
            for (int a = 0; a < D; ++a) {
                const int row = number_[static_cast<std::size_t>(D * patch.node[i] + a)];
                if (row >= 0) g.row(row) += load.node_N[i][a] * stiffness_by.row(m);
            }
    }
    const Eigen::MatrixXd du = -factor_.solve(Eigen::MatrixXd(g));
    for (std::size_t i = 0; i < number_.size(); ++i)
        if (number_[i] >= 0) by.displacement.row(static_cast<Eigen::Index>(i)) = du.row(number_[i]);
    for (int i = 0; i < ContactPatch::size; ++i)
        by.contact_force -= patch.weight[i] * contact_->gap_N_m * by.displacement.middleRows(D * patch.node[i], D);
    return by;
}

}  // namespace tissue
