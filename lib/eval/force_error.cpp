#include "eval/force_error.h"

#include <algorithm>
#include <cmath>

#include "train/force_loss.h"

namespace tissue {

std::vector<int> loaded_nodes(const SpringMesh& mesh, const PathRecord& record) {
    const double least = 1e-9 * record.force.cwiseAbs().maxCoeff();
    std::vector<int> nodes;
    for (int i = 0; i < mesh.node_count(); ++i)
        if (record.force.row(i).cwiseAbs().maxCoeff() > least && !std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), i))
            nodes.push_back(i);
    return nodes;
}

double resolved_force(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                      const std::vector<int>& nodes, const Eigen::Vector2d& direction, const NodeField& displacement) {
    const Eigen::VectorXd f = law.force_matrix(mesh, displacement) * theta;
    double sum = 0;
    for (int node : nodes) sum += f.segment<2>(2 * node).dot(direction);
    return sum;
}

double resolved_force(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                      const SurfacePoint& contact, const Eigen::Vector2d& direction, const NodeField& displacement) {
    std::vector<int> nodes;
    for (int end : {0, 1})
        if (contact.weight[end] > 0) nodes.push_back(contact.node[end]);
    return resolved_force(mesh, law, theta, nodes, direction, displacement);
}

ForceError force_error(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                       const SurfacePoint& contact, const Eigen::VectorXd& node_weight, const LoadPath& path,
                       const PathRecord& record) {
    const NodeField weight = node_weight.replicate(1, mesh.dimension());
    const ForceLoss loss(law.force_matrix(mesh, record.displacement), as_vector(record.force), as_vector(weight));
    const double fe = record.contact_force_N.dot(path.direction);
    const std::vector<int> loaded = loaded_nodes(mesh, record);
    const double model =
        loaded.empty() ? resolved_force(mesh, law, theta, contact, path.direction, record.displacement)
                       : resolved_force(mesh, law, theta, loaded, path.direction, record.displacement);
    return {loss.relative(theta), model, fe != 0 ? std::abs(model - fe) / std::abs(fe) : std::nan("")};
}

}  // namespace tissue
