#include "train/node_weights.h"

#include "train/stream.h"

namespace tissue {

Eigen::VectorXd draw_node_weights(const Study& study, const SpringMesh& mesh, const LoadCase& load) {
    const Stream stream(study.training.seed, "weights", load.name);
    // half size of the near region along each axis; on a shape the mean spring length with a margin for corners
    double spring_m = 0;
    for (int s = 0; s < mesh.spring_count(); ++s) spring_m += mesh.rest_length(s) / mesh.spring_count();
    const Eigen::Vector2d reach = study.geometry.is_block()
                                      ? Eigen::Vector2d(1.01 * study.geometry.width_m / study.cells[0],
                                                        1.01 * study.geometry.height_m / study.cells[1])
                                      : Eigen::Vector2d::Constant(1.2 * spring_m);
    Eigen::VectorXd weight(mesh.node_count());
    for (int i = 0; i < mesh.node_count(); ++i) {
        const Eigen::Vector2d away = (mesh.nodes.row(i).transpose() - load.path->contact_m).cwiseAbs();
        const bool near = away.x() <= reach.x() && away.y() <= reach.y();
        weight[i] = stream.uniform(near ? study.training.weight_near : study.training.weight_far);
    }
    return weight;
}

}  // namespace tissue
