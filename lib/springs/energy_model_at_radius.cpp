#include "springs/energy_model_at_radius.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "error.h"
#include "springs/ball_contact.h"
#include "springs/energy_model_terms.h"
#include "springs/patch_sizes.h"

namespace tissue {
namespace {

/// Throws MismatchError unless the model was trained for discs of that radius.
void check_radius(const EnergyModel& energy_model, const std::string& what, double radius_m) {
    constexpr double same = 1e-9;
    const PatchSizes sizes(energy_model);
    if (radius_m >= sizes.least_m() * (1 - same) && radius_m <= sizes.most_m() * (1 + same)) return;
    throw MismatchError(fmt::format("{} of radius {:g} mm: the model {}", what, 1e3 * radius_m,
                                    energy_model.sizes.empty() ? fmt::format("has only a disc of {:g} mm", 1e3 * sizes.most_m()) : fmt::format("was trained with discs from {:g} to {:g} mm", 1e3 * sizes.least_m(), 1e3 * sizes.most_m())));
}

}  // namespace

EnergyModel energy_model_of_contact(const EnergyModel& energy_model, double radius_m) {
    if (energy_model.sizes.empty()) throw MismatchError(fmt::format("the model has only a disc of {:g} mm", 1e3 * energy_model.disc_radius_m));
    const PatchSizes sizes(energy_model);
    EnergyModel other = energy_model;
    other.disc_radius_m = radius_m;
    other.patch = sizes.at(radius_m);
    other.disc.correction = energy_model.sizes.correction_at(radius_m);
    if (radius_m < sizes.least_m()) other.disc.correction.value *= radius_m / sizes.least_m();
    other.sizes = {};
    return other;
}

EnergyModel energy_model_of_ball(const EnergyModel& energy_model, double ball_m, double contact_m) {
    EnergyModel other = energy_model_of_contact(energy_model, contact_m);
    other.disc.ball_contact_m = BallContact::largest * ball_m;
    other.disc.sizes = energy_model.sizes;
    return other;
}

EnergyModel energy_model_at_radius(const EnergyModel& energy_model, double radius_m) {
    if (radius_m == 0 || radius_m == energy_model.disc_radius_m) return energy_model;
    check_radius(energy_model, "a disc", radius_m);
    EnergyModel other = energy_model_of_contact(energy_model, radius_m);
    // exactly the values that training used
    other.patch = resized(energy_model.patch, energy_model.terms, energy_model.coefficients, energy_model.disc_radius_m, energy_model.sizes.spacing_m, std::log(radius_m / energy_model.disc_radius_m));
    return other;
}

TissueModel with_tool(TissueModel model, const ToolChoice& tool) {
    if (tool.is_default()) return model;
    if (!model.energy_model || !model.mesh.is_solid()) throw MismatchError(fmt::format("tool {}: the model is in the plane and has no disc", to_string(tool)));
    EnergyModel& energy_model = *model.energy_model;
    if (tool.shape == ToolChoice::Shape::disc) {
        energy_model = energy_model_at_radius(energy_model, tool.radius_m);
        return model;
    }
    if (energy_model.sizes.empty()) throw MismatchError(fmt::format("tool {}: a ball needs a model trained with several discs, and the model has only a disc of {:g} mm", to_string(tool), 1e3 * energy_model.disc_radius_m));
    if (!energy_model.relaxation.empty()) throw MismatchError(fmt::format("tool {}: a ball is not possible with a model that relaxes", to_string(tool)));
    check_radius(energy_model, fmt::format("tool {}: at half depth it has a contact", to_string(tool)), BallContact::half_in * tool.radius_m);
    energy_model = energy_model_of_ball(energy_model, tool.radius_m, BallContact::half_in * tool.radius_m);
    return model;
}

}  // namespace tissue
