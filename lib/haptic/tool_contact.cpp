#include "haptic/tool_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "springs/energy_model_kernel.h"

namespace tissue {

ToolContact::ToolContact(const SpringMesh& mesh, const EnergyModel& energy_model, double ball_m) : kernel_(make_contact_kernel(mesh, energy_model)), patch_(energy_model.patch), skin_(energy_model.skin()), ball_{ball_m} {
    if (ball_m > 0) sizes_ = PatchSizes(energy_model);
}

ToolContact::ToolContact(const ToolContact& other) : kernel_(other.kernel_->clone()), patch_(other.patch_), skin_(other.skin_), ball_(other.ball_), sizes_(other.sizes_) {}

namespace {

constexpr double smallest_contact = 0.02;  // a / R_e: of a ball that just touches

}  // namespace

ToolContact::BallAt ToolContact::ball_at(int facet, const Eigen::Vector3d& weight, const Point& push_m) const noexcept {
    const ContactKernel::SurfaceAt surface = kernel_->surface_at(facet, weight);
    const double effective_m = ball_.effective_m(surface.curvature_1_m), depth_m = surface.inward.dot(Eigen::Vector3d(push_m)), radius_m = BallContact::contact_m(effective_m, depth_m);
    const double smallest_m = smallest_contact * effective_m;
    return {push_m, surface.inward, effective_m, depth_m, std::max(radius_m, smallest_m), radius_m < smallest_m ? 0 : BallContact::growth(effective_m, depth_m)};
}

void ToolContact::at(int facet, const Eigen::Vector3d& weight, const Point& push_m, const NodeColumns& u, ToolSpring& tool) const noexcept {
    if (!grows()) return kernel_->tool_at(facet, weight, 0, patch_, tool);
    constexpr double step = 0.01;  // relative step of the radius, for dE/da
    const BallAt ball = ball_at(facet, weight, push_m);
    const Eigen::Vector3d along = ball.push_m - ball.depth_m * ball.inward;
    ToolSpring::Growth now{ball.radius_m, 0, ball.depth_m, {}, tool.growth().rings};
    // first touch: bound at zero displacement
    if (tool.growth().radius_m == 0) now.rings = BoundRings(BallContact::largest * ball_.radius_m, smallest_contact * ball.effective_m, Eigen::Vector3d::Zero());
    now.rings.follow(ball.radius_m, along);
    now.anchor_m = now.rings.mean_m();
    now.anchor_m -= ball.inward.dot(now.anchor_m) * ball.inward;
    at(facet, weight, now, tool);
    if (ball.growth == 0) return;
    // growth leaves the energy stored along the surface unchanged, as in BallIndentation: sqrt(radius) times the stretch is
    // constant
    ToolSpring larger;
    ToolSpring::Growth more = now;
    more.radius_m *= 1 + step;
    more.anchor_m = along - (along - now.anchor_m) / std::sqrt(1 + step);
    at(facet, weight, more, larger);
    const double most_N = tool.most_N();
    tool.show_at_most(std::numeric_limits<double>::infinity());
    const double here_J = tool.energy_J(push_m, u), there_J = larger.energy_J(push_m, u);
    tool.show_at_most(most_N);
    // exact where E is a power of the radius. A tool that stays behind the hand never reaches push_m: there this part
    // is at most a fifth of the largest force, its share of a ball's force on a half space
    if (here_J > 0 && there_J > 0) now.force_N = std::min(ball.growth * here_J / ball.radius_m * std::log(there_J / here_J) / std::log1p(step), most_N / 5);
    tool.grow(now);
}

void ToolContact::at(int facet, const Eigen::Vector3d& weight, const ToolSpring::Growth& growth, ToolSpring& tool) const noexcept {
    kernel_->tool_at(facet, weight, growth.radius_m, growth.radius_m > 0 ? sizes_.at(growth.radius_m) : patch_, tool);
    tool.grow(growth);
}

void ToolContact::show_skin(int facet, const Eigen::Vector3d& weight, const Point& push_m, NodeColumns& u) const noexcept {
    const double radius_m = grows() ? ball_at(facet, weight, push_m).radius_m : 0;
    kernel_->show_skin(facet, weight, radius_m, skin_, push_m, u);
}

void ToolContact::become(const ContactParameters& patch, const Eigen::VectorXd& log_scale) noexcept {
    patch_ = patch;
    scale(log_scale);
}

}  // namespace tissue
