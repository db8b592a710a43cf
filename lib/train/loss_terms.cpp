#include "train/loss_terms.h"

#include <Eigen/Cholesky>

namespace tissue {

Target force_target(const LoadCase& load, const Eigen::VectorXd& node_weight) {
    const NodeField& u = load.record->displacement;
    return {u, load.record->force, node_weight.replicate(1, u.cols())};
}

Target contact_target(const SpringMesh& mesh, const LoadCase& load, const SurfacePoint& contact,
                      const Eigen::VectorXd& node_weight) {
    Target target = force_target(load, node_weight);
    const Eigen::RowVectorXd push = (load.path->direction * load.record->magnitude_m).transpose();
    Eigen::RowVectorXd there = Eigen::RowVectorXd::Zero(push.size());
    double squares = 0;
    for (int end : {0, 1}) {
        there += contact.weight[end] * target.displacement.row(contact.node[end]);
        squares += contact.weight[end] * contact.weight[end];
    }
    target.force.setZero();
    for (int end : {0, 1}) {
        // smallest change of both ends that gives the contact the prescribed tool displacement
        target.displacement.row(contact.node[end]) += contact.weight[end] / squares * (push - there);
        target.force.row(contact.node[end]) += contact.weight[end] * load.record->contact_force_N.transpose();
    }
    for (int node : mesh.fixed) target.weight.row(node).setZero();
    return target;
}

ForceLoss loss_of(const SpringMesh& mesh, const SpringLaw& law, const Target& target) {
    return {law.force_matrix(mesh, target.displacement), as_vector(target.force), as_vector(target.weight)};
}

ForceLoss with_ridge(const ForceLoss& loss, double ridge, const Eigen::VectorXd& theta0) {
    const Eigen::Index S = theta0.size();
    const double root = std::sqrt(ridge * loss.matrix().squaredNorm() / static_cast<double>(S));
    SparseMatrix identity(S, S);
    identity.setIdentity();
    return loss.with_rows(root * identity, root * theta0);
}

ForceLoss with_reaction(const ForceLoss& loss, const SpringMesh& mesh, const SpringLaw& law, const Target& target,
                        const Eigen::MatrixXd& sensitivity, double factor) {
    const Eigen::MatrixXd GA = factor * sensitivity * law.force_matrix(mesh, target.displacement);
    return loss.with_rows(GA.sparseView(), factor * sensitivity * as_vector(target.force));
}

std::optional<ForceLoss> joint_loss(const std::vector<ForceLoss>& losses) {
    if (losses.empty()) return std::nullopt;
    const Eigen::Index S = losses.front().matrix().cols();
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(S, S);
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(S);
    for (const ForceLoss& loss : losses) {
        const double target = loss.target().norm();
        if (!(target > 0)) continue;
        const double weight = 1 / (target * target);
        normal += weight * Eigen::MatrixXd(SparseMatrix(loss.matrix().transpose() * loss.matrix()));
        rhs += weight * (loss.matrix().transpose() * loss.target());
    }
    if (!(normal.trace() > 0)) return std::nullopt;
    normal.diagonal().array() += 1e-12 * normal.trace() / static_cast<double>(S);  // gives zero columns a pivot
    const Eigen::LLT<Eigen::MatrixXd> factor(normal);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const Eigen::MatrixXd upper = factor.matrixU();
    return ForceLoss(upper.sparseView(), factor.matrixL().solve(rhs), Eigen::VectorXd::Ones(S));
}

}  // namespace tissue
