#include "train/force_loss.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "error.h"

namespace tissue {
namespace {

void append(std::vector<Eigen::Triplet<double>>& entries, const SparseMatrix& block, Eigen::Index first_row) {
    for (int c = 0; c < block.outerSize(); ++c)
        for (SparseMatrix::InnerIterator it(block, c); it; ++it)
            entries.emplace_back(static_cast<int>(first_row + it.row()), c, it.value());
}

}  // namespace

ForceLoss::ForceLoss(const SparseMatrix& A, const Eigen::VectorXd& force, const Eigen::VectorXd& weight) {
    if (A.rows() != force.size() || A.rows() != weight.size())
        throw MismatchError(fmt::format("force loss: A has {} rows, the force {} entries, the weight {} entries", A.rows(),
                                        force.size(), weight.size()));
    const Eigen::VectorXd root = weight.cwiseSqrt();
    matrix_ = root.asDiagonal() * A;
    target_ = root.cwiseProduct(force);
    scale_ = target_.norm();
}

ForceLoss ForceLoss::with_rows(const SparseMatrix& extra, const Eigen::VectorXd& wanted) const {
    const Eigen::Index rows = matrix_.rows();
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(matrix_.nonZeros() + extra.nonZeros()));
    append(entries, matrix_, 0);
    append(entries, extra, rows);
    ForceLoss more = *this;
    more.matrix_.resize(rows + extra.rows(), matrix_.cols());
    more.matrix_.setFromTriplets(entries.begin(), entries.end());
    more.target_.resize(more.matrix_.rows());
    more.target_ << target_, wanted;
    return more;
}

double ForceLoss::operator()(const Eigen::VectorXd& theta, Eigen::VectorXd& workspace) const {
    workspace = target_;
    workspace.noalias() -= matrix_ * theta;
    return workspace.norm();
}

double ForceLoss::operator()(const Eigen::VectorXd& theta) const {
    Eigen::VectorXd workspace;
    return (*this)(theta, workspace);
}

double ForceLoss::relative(const Eigen::VectorXd& theta) const {
    return scale_ > 0 ? (*this)(theta) / scale_ : std::nan("");
}

}  // namespace tissue
