#include "springs/law_at_radius.h"

#include <fmt/format.h>

#include <cmath>

#include "error.h"
#include "springs/energy_law.h"

namespace tissue {

LawModel law_at_radius(const LawModel& law, double radius_m) {
    constexpr double same = 1e-9;
    if (radius_m == 0 || radius_m == law.disc_radius_m) return law;
    const Eigen::VectorXd& known = law.sizes.radii_m;
    const double least = known.size() > 0 ? known[0] : law.disc_radius_m, most = known.size() > 0 ? known[known.size() - 1] : law.disc_radius_m;
    if (!(radius_m >= least * (1 - same) && radius_m <= most * (1 + same)))
        throw MismatchError(fmt::format("a disc of radius {:g} mm: the model was trained under {}", 1e3 * radius_m,
                                        known.size() > 0 ? fmt::format("discs from {:g} to {:g} mm", 1e3 * least, 1e3 * most) : fmt::format("a disc of {:g} mm alone", 1e3 * most)));
    LawModel other = law;
    other.disc_radius_m = radius_m;
    other.patch = resized(law.patch, law.terms, law.coefficients, std::log(radius_m / law.disc_radius_m));
    other.disc.correction = law.sizes.correction_at(radius_m);
    other.sizes = {};
    return other;
}

TissueModel with_tool(TissueModel model, double radius_m) {
    if (radius_m == 0) return model;
    if (!model.energy_law || !model.mesh.is_solid()) throw MismatchError("tool-radius: the model is of the plane, and has no disc");
    model.energy_law = law_at_radius(*model.energy_law, radius_m);
    return model;
}

}  // namespace tissue
