#include "springs/ball_press.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "error.h"
#include "springs/ball_contact.h"
#include "springs/contact_errors.h"
#include "springs/contact_spring.h"
#include "springs/energy_law.h"
#include "springs/law_at_radius.h"
#include "springs/law_kernel.h"
#include "springs/law_press.h"

namespace tissue {
namespace {

double largest_m(const LawModel& law) { return law.sizes.radii_m[law.sizes.radii_m.size() - 1]; }

/// What is stored in the contact alone, tissue held where it is.
double contact_energy_J(const SpringMesh& mesh, const LawModel& law, const Point& contact_m, const Point& push_m, const NodeField& u) {
    const ContactSpring contact(make_contact_kernel(mesh, law)->rows_at(contact_m), law.patch);
    return contact.load(push_m, contact.gather(u)).energy_J;
}

}  // namespace

BallPress::BallPress(const SpringMesh& mesh, LawModel law, double radius_m) : mesh_(mesh), law_(std::move(law)), radius_m_(radius_m) {
    if (!mesh.is_solid() || !(law_.disc_radius_m > 0)) throw MismatchError("a ball needs a law in space");
    if (!(radius_m > 0 && std::isfinite(radius_m))) throw MismatchError(fmt::format("a ball needs a radius > 0, got {} m", radius_m));
    if (law_.sizes.empty()) throw MismatchError(fmt::format("a ball's contact grows: it needs a model trained under discs of several radii, not of {:g} mm alone", 1e3 * law_.disc_radius_m));
    kernel_ = make_contact_kernel(mesh, law_of_ball(law_, radius_m, BallContact::half_in * radius_m));
}

BallPress::Place BallPress::place_at(const Point& contact_m) const {
    const ContactRows rows = kernel_->rows_at(contact_m);
    const double curvature_1_m = rows.factors[PatchLaw::curved_factor] / (BallContact::half_in * radius_m_);
    return {rows.push.row(0).transpose(), BallContact{radius_m_}.effective_m(curvature_1_m)};
}

double BallPress::contact_radius_m(const Place& place, const Point& push_m) const {
    return BallContact::contact_m(place.radius_m, place.inward.dot(push_m));
}

double BallPress::contact_radius_m(const Point& contact_m, const Point& push_m) const { return contact_radius_m(place_at(contact_m), push_m); }

Equilibrium BallPress::at(const Point& contact_m, const Point& push_m) const {
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
    const auto refuse = [&](const std::string& why) { throw ContactTooLargeError(fmt::format("a ball of {:g} mm pushed {:.3g} mm in {}", 1e3 * radius_m_, 1e3 * depth_m, why)); };
    if (depth_m > place.radius_m || a_m > radius_m_) refuse("is more than half in the tissue");
    if (a_m > largest_m(law_) * (1 + 1e-9))
        refuse(fmt::format("has a contact of radius {:.3g} mm: the model was trained under discs of {:g} mm at the most", 1e3 * a_m, 1e3 * largest_m(law_)));
    const LawPress disc(mesh_, law_of_ball(law_, radius_m_, a_m));
    const Point straight = depth_m * place.inward, along = BallContact::bound_part(place.radius_m, depth_m) * (push_m - straight);
    Equilibrium answer = disc.at(contact_m, straight + along);
    if (!answer) return answer;
    // dE/da of the whole at rest is that of the contact with the tissue held
    constexpr double step = 0.02;
    const double low_m = (1 - step) * a_m, high_m = std::min((1 + step) * a_m, largest_m(law_));
    // what is stored along the surface stays as the contact grows: sqrt(a) times the stretch
    const auto energy_J = [&](double radius_m) { return contact_energy_J(mesh_, law_of_ball(law_, radius_m_, radius_m), contact_m, straight + std::sqrt(a_m / radius_m) * along, answer.displacement); };
    answer.contact_force += (energy_J(high_m) - energy_J(low_m)) / (high_m - low_m) * BallContact::growth(place.radius_m, depth_m) * place.inward;
    answer.displacement = disc.seen(contact_m, push_m, std::move(answer.displacement));
    return answer;
}

}  // namespace tissue
