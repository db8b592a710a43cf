#include "haptic/selector.h"

#include <fmt/format.h>

#include <algorithm>

#include "error.h"
#include "springs/equilibrium.h"

namespace tissue {
namespace {

/// Tool displacement of each load case [m]; by force: the contact force of its own spring set there [N] (C).
Eigen::VectorXd push_sizes(const TissueModel& model, const Eigen::Ref<const NodeField>& theta, SelectBy by) {
    if (model.case_count() == 0) throw MismatchError("the model has no spring sets");
    Eigen::VectorXd sizes = model.magnitude_m;
    if (by == SelectBy::displacement) return sizes;
    const auto law = make_spring_law(model.law);
    for (int c = 0; c < model.case_count(); ++c) {
        const Eigen::Vector2d position = model.contact_m.row(c), push = model.magnitude_m[c] * model.direction.row(c);
        const auto rest = solve_equilibrium(model.mesh, *law, theta.row(c).transpose(),
                                            locate_on_surface(model.mesh, position), push);
        if (!rest)
            throw MismatchError(fmt::format("set '{}' cannot be selected by force: {}",
                                            model.case_names[static_cast<std::size_t>(c)], reason_of(rest.status)));
        sizes[c] = rest.contact_force.norm();
    }
    return sizes;
}

}  // namespace

Selector::Selector(const TissueModel& model, const Eigen::Ref<const NodeField>& theta, SelectBy by)
    : Selector(model, push_sizes(model, theta, by)) {}

Selector::Selector(const TissueModel& model, const Eigen::VectorXd& sizes)
    : grid_(model.mesh, model.contact_m, model.direction, sizes), small_(0.01 * sizes.minCoeff()) {
    const SpringMesh& mesh = model.mesh;
    for (Eigen::Index b = 0; b < mesh.facets.rows(); ++b) {
        const Eigen::Vector2d start = mesh.nodes.row(mesh.facets(b, 0)), end = mesh.nodes.row(mesh.facets(b, 1));
        outline_m_.push_back(start);
        normal_.push_back(Eigen::Vector2d(-(end - start).y(), (end - start).x()).normalized());
    }
}

int Selector::select(int segment, double w, const Eigen::Vector2d& push) const noexcept {
    const auto b = static_cast<std::size_t>(segment);
    const Eigen::Vector2d position = (1 - w) * outline_m_[b] + w * outline_m_[(b + 1) % outline_m_.size()];
    const Eigen::Vector2d directed = push + std::max(0.0, small_ - push.norm()) * normal_[b];
    const double arc = grid_.outline().arc_of(position), size = directed.norm();
    const Eigen::Vector2d direction = size > 0 ? Eigen::Vector2d(directed / size) : normal_[b];
    return grid_.nearest(arc, direction, size);
}

}  // namespace tissue
