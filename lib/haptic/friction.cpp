#include "haptic/friction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "error.h"

namespace tissue {
namespace {

// Slides are short, so that the contact's rows change little in each.
constexpr int most_steps = 4, most_halvings = 6;  // of one call; outside() halves up to twice as often
constexpr double farthest_m = 0.05;               // longest step of outside()
constexpr double on_cone = 1e-3;                  // tolerance of |f_t| on the cone, over mu f_n
constexpr double longest = 0.5;                   // longest slide, over the spacing of the surface's nodes

/// The tool's force on the tissue at a tool displacement, split into its tangential and its normal part.
struct Pull {
    Pull(const Point& push, const NodeColumns& u, const ToolSpring& tool, const ToolMemory& memory) noexcept {
        const Point hand = tool.tool_force_N(push, u, &memory), inward = tool.inward();
        pressed_N = std::max(0.0, hand.dot(inward));
        direction = hand - hand.dot(inward) * inward;
        drag_N = direction.norm();
        if (drag_N > 0) direction /= drag_N;
    }
    /// Tangential distance of the tool from the cone of mu, by the tangent stiffness [m]. 0 where that is not positive.
    double outside_m(double mu, const Point& push, const NodeColumns& u, const ToolSpring& tool, const ToolMemory& memory) const noexcept {
        const double stiffness = direction.dot(tool.stiffness_N_m(push, u, &memory) * direction);
        return stiffness > 0 ? (drag_N - mu * pressed_N) / stiffness : 0;
    }
    bool outside(double mu) const { return drag_N > mu * pressed_N + on_cone * (mu * pressed_N + 1e-6 * drag_N); }

    double pressed_N, drag_N;
    Point direction;  ///< unit vector of the tangential force
};

}  // namespace

Friction::Friction(const FrictionOptions& options) : stick_(options.stick), slip_(options.slip.value_or(options.stick)), has_slip_(options.slip.has_value()) {
    if (!(stick_ >= 0)) throw MismatchError(fmt::format("friction must not be negative, not {}", stick_));
    if (!(slip_ >= 0)) throw MismatchError(fmt::format("friction-slip must not be negative, not {}", slip_));
    if (options.slip && std::isinf(stick_)) throw MismatchError("friction-slip has no effect while friction is inf, where the tool never slips: set friction too");
    if (!(slip_ <= stick_)) throw MismatchError(fmt::format("kinetic friction {} must not be above the static {}", slip_, stick_));
}

Point Friction::slide(const FreeSurface& surface, const RealtimeMesh& mesh, const ToolContact& contacts, const NodeColumns& u, const Point& tool_m,
                     SurfacePlace& where, Point& touched_m, ToolSpring& tool, ToolMemory& memory, ToolMemory* beside) noexcept {
    Point drags = Point::Zero(tool_m.size());
    if (std::isinf(stick_)) return drags;
    bool slips = false;
    for (int step = 0; step < most_steps; ++step) {
        const Point push = tool_m - touched_m;
        const Pull pull(push, u, tool, memory);
        if (!pull.outside(slips ? slip_ : cone())) break;
        if (!slips) drags = pull.direction;  // the direction of the first step; later steps correct it
        slips = true;
        slipping_ = true;
        double way_m = std::min(pull.outside_m(slip_, push, u, tool, memory), longest * surface.spacing_m());
        const double before_J = tool.energy_J(push, u, &memory);
        bool falls = false;
        for (int half = 0; half < most_halvings && !falls; ++half, way_m /= 2) {
            const FreeSurface::Walk walk = surface.walk(where.facet, where.weight, way_m * pull.direction);
            if (!(walk.walked_m > 0)) break;
            const Point place = mesh.rest_place(walk.facet, walk.weight);
            next_.show_at_most(tool.most_N());
            contacts.at(walk.facet, walk.weight, tool.growth(), next_);  // the next tick updates its growth
            next_memory_ = memory;
            next_memory_.follow(tool, next_);
            const double after_J = next_.energy_J(tool_m - place, u, &next_memory_);
            if (!(after_J <= before_J)) continue;
            falls = true;
            where.facet = walk.facet;
            where.weight = walk.weight;
            touched_m = place;
            if (beside) beside->follow(tool, next_);
            tool = next_;
            memory = next_memory_;
        }
        if (!falls) break;
    }
    slipping_ = slips;
    return drags;
}

Point Friction::outside(const Point& push, const NodeColumns& u, const ToolSpring& tool, const ToolMemory& memory) const noexcept {
    Point sum = Point::Zero(push.size());
    if (std::isinf(stick_)) return sum;
    for (int step = 0; step < most_steps; ++step) {
        const Pull pull(push - sum, u, tool, memory);
        if (!pull.outside(cone())) break;
        // farthest_m: at its largest force the tool has almost no stiffness
        double way_m = std::min(pull.outside_m(cone(), push - sum, u, tool, memory), farthest_m);
        for (int half = 0; half < 2 * most_halvings && tool.tool_force_N(push - sum - way_m * pull.direction, u, &memory).dot(pull.direction) < 0; ++half) way_m /= 2;
        sum += way_m * pull.direction;
    }
    return sum;
}

Point Friction::slide(const FreeSurface& surface, const RealtimeMesh& mesh, const MovingSurface& now, double coupling_N_m, const Point& tool_m,
                     SurfacePlace& where) noexcept {
    if (std::isinf(stick_)) return Point::Zero(2);
    // Spring sets exist in the plane only. The tangent is that of the segment at rest, since the nodes of the segment
    // go up and down while the tool passes.
    const Eigen::Vector2d from = mesh.rest_place(where.facet, {1, 0, 0}), to = mesh.rest_place(where.facet, {0, 1, 0});
    const Eigen::Vector2d tangent = (to - from).normalized(), inward(-tangent.y(), tangent.x());
    const Eigen::Vector2d gap = tool_m - where.position_m;
    const double pressed = std::max(0.0, coupling_N_m * gap.dot(inward)), drag = coupling_N_m * gap.dot(tangent);
    slipping_ = std::abs(drag) > cone() * pressed * (1 + on_cone);
    if (!slipping_) return Point::Zero(2);
    const Point drags = std::copysign(1.0, drag) * tangent;
    double way_m = std::min((std::abs(drag) - slip_ * pressed) / coupling_N_m, longest * surface.spacing_m());
    const double before_J = coupling_N_m * (tool_m - where.position_m).squaredNorm() / 2;
    for (int half = 0; half < most_halvings; ++half, way_m /= 2) {
        const Point along = way_m * drags;
        const FreeSurface::Walk walk = surface.walk(where.facet, where.weight, along);
        if (!(walk.walked_m > 0)) break;
        const Point place = now.at(walk.facet, walk.weight);
        const double after_J = coupling_N_m * (tool_m - place).squaredNorm() / 2;
        if (!(after_J <= before_J)) continue;
        where.facet = walk.facet;
        where.weight = walk.weight;
        where.position_m = place;
        where.distance_m = (tool_m - place).norm();
        break;
    }
    return drags;
}

}  // namespace tissue
