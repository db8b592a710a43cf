#include "eval/table_pushes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mesh/topology.h"
#include "springs/supports.h"

namespace tissue {
namespace {

constexpr double same_m = 1e-7, same_direction = 1e-6;

bool same_push(const TablePush& a, const TablePush& b) {
    return std::abs(a.depth_m - b.depth_m) < same_m && (a.contact_m - b.contact_m).norm() < same_m && (a.direction - b.direction).norm() < same_direction;
}

/// Whether the tissue is a block with fixed nodes at its whole bottom and nowhere else, and with uniform supports.
bool is_block(const TissueModel& model) {
    const SpringMesh& mesh = model.mesh;
    if (!mesh.is_solid()) return on_lattice(mesh);
    if (!is_box(mesh)) return false;
    const auto up = mesh.own_nodes().col(2);
    const double low_m = up.minCoeff();
    for (int node = 0; node < up.size(); ++node)
        if ((up[node] - low_m < same_m) != std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), node)) return false;
    if (!model.energy_model) return true;
    const Eigen::VectorXd pressure = model.energy_model->constants.tail(mesh.support_count()).cwiseQuotient(fixed_areas(mesh));
    return pressure.maxCoeff() - pressure.minCoeff() < 1e-6 * pressure.maxCoeff();
}

/// Whether each point of an inclusion (G x 4: place, weight) has a point of the same weight at its image.
bool maps_onto_itself(const NodeField& ground, const Symmetry& s) {
    for (Eigen::Index i = 0; i < ground.rows(); ++i) {
        const Point at = ground.row(i).head<3>().transpose(), image = s.centre_m + s.turn * (at - s.centre_m);
        const auto is_image = [&](Eigen::Index k) {
            return (Point(ground.row(k).head<3>().transpose()) - image).norm() < same_m && std::abs(ground(k, 3) - ground(i, 3)) <= 1e-6 * std::abs(ground(i, 3));
        };
        bool found = false;
        for (Eigen::Index k = 0; k < ground.rows() && !found; ++k) found = is_image(k);
        if (!found) return false;
    }
    return true;
}

}  // namespace

std::vector<Symmetry> symmetries_of(const TissueModel& model) {
    if (!is_block(model)) return {};
    const NodeField ground = model.energy_model ? model.energy_model->disc.ground : NodeField();
    const Point low = model.mesh.own_nodes().colwise().minCoeff().transpose(), high = model.mesh.own_nodes().colwise().maxCoeff().transpose();
    const Point centre_m = (low + high) / 2, size_m = high - low;
    const Eigen::Index D = size_m.size();
    std::vector<Symmetry> found;
    for (bool exchanged : {false, true})
        for (double y : {1.0, -1.0})
            for (double x : {1.0, -1.0}) {
                const bool identity = !exchanged && x > 0 && y > 0;
                if (identity || (D == 2 && (exchanged || y < 0))) continue;  // in two dimensions y is the height
                if (exchanged && std::abs(size_m[0] - size_m[1]) > same_m) continue;
                Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(D, D);
                turn(0, 0) = x;
                if (D == 3) turn(1, 1) = y;
                if (exchanged) turn.topRows(2) = Eigen::MatrixXd(turn.topRows(2).colwise().reverse());
                const Symmetry s{turn, centre_m};
                if (maps_onto_itself(ground, s)) found.push_back(s);
            }
    return found;
}

std::vector<TablePush> table_pushes(const std::vector<LoadCase>& loads, const std::vector<Symmetry>& symmetries, double disc_radius_m) {
    std::vector<TablePush> pushes;
    for (const LoadCase& load : loads) {
        const double times = load.path->radius_m > 0 && disc_radius_m > 0 ? load.path->radius_m / disc_radius_m : 1;
        pushes.push_back({load.path->contact_m, load.path->direction, load.record->contact_force_N / (times * times), load.record->magnitude_m / times});
    }
    const std::size_t own = pushes.size();
    std::vector<std::size_t> source(own);  // for each entry the load case that it is, or that it is an image of
    std::iota(source.begin(), source.end(), std::size_t{0});
    for (std::size_t i = 0; i < own; ++i)
        for (const Symmetry& s : symmetries) {
            const TablePush push = pushes[i];
            const TablePush image = {s.centre_m + s.turn * (push.contact_m - s.centre_m), s.turn * push.direction, s.turn * push.force_N, push.depth_m};
            bool known = false;
            for (std::size_t k = 0; k < pushes.size() && !known; ++k) {
                const bool of_a_repeat = k >= own && source[k] != i && same_push(pushes[source[k]], push);
                known = !of_a_repeat && same_push(pushes[k], image);
            }
            if (known) continue;
            pushes.push_back(image);
            source.push_back(i);
        }
    return pushes;
}

}  // namespace tissue
