#include "springs/ball_indentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "error.h"
#include "springs/ball_contact.h"
#include "springs/contact_errors.h"
#include "springs/contact_spring.h"
#include "springs/energy_model_terms.h"
#include "springs/energy_model_at_radius.h"
#include "springs/energy_model_kernel.h"
#include "springs/indentation_solver.h"

namespace tissue {
namespace {

double largest_m(const EnergyModel& energy_model) { return energy_model.sizes.radii_m[energy_model.sizes.radii_m.size() - 1]; }

/// Energy of the contact alone [J], with the mesh fixed at the displacement u.
double contact_energy_J(const SpringMesh& mesh, const EnergyModel& energy_model, const Point& contact_m, const Point& push_m, const NodeField& u) {
    const ContactSpring contact(make_contact_kernel(mesh, energy_model)->rows_at(contact_m), energy_model.patch);
    return contact.load(push_m, contact.gather(u)).energy_J;
}

}  // namespace

BallIndentation::BallIndentation(const SpringMesh& mesh, EnergyModel energy_model, double radius_m) : mesh_(mesh), law_(std::move(energy_model)), radius_m_(radius_m) {
    if (!mesh.is_solid() || !(law_.disc_radius_m > 0)) throw MismatchError("a ball needs an energy model in space");
    if (!(radius_m > 0 && std::isfinite(radius_m))) throw MismatchError(fmt::format("the radius of a ball must be > 0, got {} m", radius_m));
    if (law_.sizes.empty()) throw MismatchError(fmt::format("the contact of a ball grows: a ball needs a model trained with discs of several radii, not only of {:g} mm", 1e3 * law_.disc_radius_m));
    kernel_ = make_contact_kernel(mesh, energy_model_of_ball(law_, radius_m, BallContact::half_in * radius_m));
}

BallIndentation::Place BallIndentation::place_at(const Point& contact_m) const {
    const ContactRows rows = kernel_->rows_at(contact_m);
    const double curvature_1_m = rows.factors[ContactParameters::curved_factor] / (BallContact::half_in * radius_m_);
    return {rows.push.row(0).transpose(), BallContact{radius_m_}.effective_m(curvature_1_m)};
}

double BallIndentation::contact_radius_m(const Place& place, const Point& push_m) const {
    return BallContact::contact_m(place.radius_m, place.inward.dot(push_m));
}

double BallIndentation::contact_radius_m(const Point& contact_m, const Point& push_m) const { return contact_radius_m(place_at(contact_m), push_m); }

Equilibrium BallIndentation::at(const Point& contact_m, const Point& push_m) const {
    Equilibrium none{NodeField::Zero(mesh_.node_count(), 3), Eigen::VectorXd::Zero(3), EquilibriumStatus::balanced};
    Place place;
    try {
        place = place_at(contact_m);
    } catch (const NoContactError&) {
        none.status = EquilibriumStatus::no_contact;
        return none;
    }
    const double depth_m = place.inward.dot(push_m), a_m = contact_radius_m(place, push_m);
    if (!(depth_m > 0)) return none;
    const auto refuse = [&](const std::string& why) { throw ContactTooLargeError(fmt::format("a ball of {:g} mm displaced by {:.3g} mm {}", 1e3 * radius_m_, 1e3 * depth_m, why)); };
    if (depth_m > place.radius_m || a_m > radius_m_) refuse("is more than half inside the tissue");
    if (a_m > largest_m(law_) * (1 + 1e-9))
        refuse(fmt::format("has a contact of radius {:.3g} mm: the largest disc of the training has {:g} mm", 1e3 * a_m, 1e3 * largest_m(law_)));
    const IndentationSolver disc(mesh_, energy_model_of_ball(law_, radius_m_, a_m));
    const Point straight = depth_m * place.inward, along = BallContact::bound_part(place.radius_m, depth_m) * (push_m - straight);
    Equilibrium answer = disc.at(contact_m, straight + along);
    if (!answer) return answer;
    // At equilibrium dE/da of the whole energy is that of the contact at fixed displacements.
    constexpr double step = 0.02;
    const double low_m = (1 - step) * a_m, high_m = std::min((1 + step) * a_m, largest_m(law_));
    // The energy stored along the surface must not change with the radius: the stretch is scaled by sqrt(a / radius).
    const auto energy_J = [&](double radius_m) { return contact_energy_J(mesh_, energy_model_of_ball(law_, radius_m_, radius_m), contact_m, straight + std::sqrt(a_m / radius_m) * along, answer.displacement); };
    answer.contact_force += (energy_J(high_m) - energy_J(low_m)) / (high_m - low_m) * BallContact::growth(place.radius_m, depth_m) * place.inward;
    answer.displacement = disc.displayed(contact_m, push_m, std::move(answer.displacement));
    return answer;
}

}  // namespace tissue
