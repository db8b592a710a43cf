#include "eval/force_error.h"

#include <gsl/gsl_statistics_double.h>

#include <algorithm>
#include <cmath>

#include "train/force_loss.h"

namespace tissue {
namespace {

double along(const NodeField& force, const SurfacePoint& contact, const Eigen::Vector2d& direction) {
    // a contact on a node has one weight of 1; between nodes both ends carry the indenter
    double sum = 0;
    for (int end : {0, 1})
        if (contact.weight[end] > 0) sum += force.row(contact.node[end]).dot(direction);
    return sum;
}

}  // namespace

Statistics statistics_of(std::vector<double> sample) {
    if (sample.empty()) return {std::nan(""), std::nan(""), std::nan(""), 0};
    std::sort(sample.begin(), sample.end());
    const auto quantile = [&](double p) { return gsl_stats_quantile_from_sorted_data(sample.data(), 1, sample.size(), p); };
    return {quantile(0.5), quantile(0.95), sample.back(), static_cast<int>(sample.size())};
}

double resolved_force(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                      const SurfacePoint& contact, const Eigen::Vector2d& direction, const NodeField& displacement) {
    const Eigen::VectorXd f = law.force_matrix(mesh, displacement) * theta;
    return along(Eigen::Map<const NodeField>(f.data(), displacement.rows(), displacement.cols()), contact, direction);
}

ForceError force_error(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                       const SurfacePoint& contact, const Eigen::VectorXd& node_weight, const LoadPath& path,
                       const PathRecord& record) {
    const NodeField weight = node_weight.replicate(1, mesh.dimension());
    const ForceLoss loss(law.force_matrix(mesh, record.displacement), as_vector(record.force), as_vector(weight));
    const double fe = record.contact_force_N.dot(path.direction);
    const double model = resolved_force(mesh, law, theta, contact, path.direction, record.displacement);
    return {loss(theta) / loss.scale(), model, std::abs(model - fe) / std::abs(fe)};
}

}  // namespace tissue
