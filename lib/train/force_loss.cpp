#include "train/force_loss.h"

#include <fmt/format.h>

#include <cmath>

#include "error.h"

namespace tissue {

ForceLoss::ForceLoss(const SparseMatrix& A, const Eigen::VectorXd& force, const Eigen::VectorXd& weight) {
    if (A.rows() != force.size() || A.rows() != weight.size())
        throw MismatchError(fmt::format("force loss: A has {} rows, the force {} entries, the weight {}", A.rows(),
                                        force.size(), weight.size()));
    const Eigen::VectorXd root = weight.cwiseSqrt();
    matrix_ = root.asDiagonal() * A;
    target_ = root.cwiseProduct(force);
    scale_ = target_.norm();
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
