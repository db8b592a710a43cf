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
void check_radius(const EnergyModel& law, const std::string& what, double radius_m) {
    constexpr double same = 1e-9;
    const PatchSizes sizes(law);
    if (radius_m >= sizes.least_m() * (1 - same) && radius_m <= sizes.most_m() * (1 + same)) return;
    throw MismatchError(fmt::format("{} of radius {:g} mm: the model {}", what, 1e3 * radius_m,
                                    law.sizes.empty() ? fmt::format("has only a disc of {:g} mm", 1e3 * sizes.most_m()) : fmt::format("was trained with discs from {:g} to {:g} mm", 1e3 * sizes.least_m(), 1e3 * sizes.most_m())));
}

}  // namespace

EnergyModel law_of_contact(const EnergyModel& law, double radius_m) {
    if (law.sizes.empty()) throw MismatchError(fmt::format("the model has only a disc of {:g} mm", 1e3 * law.disc_radius_m));
    const PatchSizes sizes(law);
    EnergyModel other = law;
    other.disc_radius_m = radius_m;
    other.patch = sizes.at(radius_m);
    other.disc.correction = law.sizes.correction_at(radius_m);
    if (radius_m < sizes.least_m()) other.disc.correction.value *= radius_m / sizes.least_m();
    other.sizes = {};
    return other;
}

EnergyModel law_of_ball(const EnergyModel& law, double ball_m, double contact_m) {
    EnergyModel other = law_of_contact(law, contact_m);
    other.disc.ball_contact_m = BallContact::largest * ball_m;
    other.disc.sizes = law.sizes;
    return other;
}

EnergyModel energy_model_at_radius(const EnergyModel& law, double radius_m) {
    if (radius_m == 0 || radius_m == law.disc_radius_m) return law;
    check_radius(law, "a disc", radius_m);
    EnergyModel other = law_of_contact(law, radius_m);
    // exactly the values that training used
    other.patch = resized(law.patch, law.terms, law.coefficients, law.disc_radius_m, law.sizes.spacing_m, std::log(radius_m / law.disc_radius_m));
    return other;
}

TissueModel with_tool(TissueModel model, const ToolChoice& tool) {
    if (tool.is_default()) return model;
    if (!model.energy_model || !model.mesh.is_solid()) throw MismatchError(fmt::format("tool {}: the model is in the plane and has no disc", to_string(tool)));
    EnergyModel& law = *model.energy_model;
    if (tool.shape == ToolChoice::Shape::disc) {
        law = energy_model_at_radius(law, tool.radius_m);
        return model;
    }
    if (law.sizes.empty()) throw MismatchError(fmt::format("tool {}: a ball needs a model trained with several discs, and the model has only a disc of {:g} mm", to_string(tool), 1e3 * law.disc_radius_m));
    if (!law.relaxation.empty()) throw MismatchError(fmt::format("tool {}: a ball is not possible with a model that relaxes", to_string(tool)));
    check_radius(law, fmt::format("tool {}: at half depth it has a contact", to_string(tool)), BallContact::half_in * tool.radius_m);
    law = law_of_ball(law, tool.radius_m, BallContact::half_in * tool.radius_m);
    return model;
}

}  // namespace tissue
