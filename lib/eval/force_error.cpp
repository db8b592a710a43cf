#include "eval/force_error.h"

#include <gsl/gsl_statistics_double.h>

#include <algorithm>
#include <cmath>

#include "train/force_loss.h"

namespace tissue {
Statistics statistics_of(std::vector<double> sample) {
    sample.erase(std::remove_if(sample.begin(), sample.end(), [](double value) { return std::isnan(value); }), sample.end());
    if (sample.empty()) return {std::nan(""), std::nan(""), std::nan(""), 0};
    std::sort(sample.begin(), sample.end());
    const auto quantile = [&](double p) { return gsl_stats_quantile_from_sorted_data(sample.data(), 1, sample.size(), p); };
    return {quantile(0.5), quantile(0.95), sample.back(), static_cast<int>(sample.size())};
}

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
