#include "springs/patch_sizes.h"

#include "error.h"
#include "springs/energy_model_terms.h"

namespace tissue {

PatchSizes::PatchSizes(const EnergyModel& energy_model) : own_(energy_model.patch), own_m_(energy_model.disc_radius_m), least_m_(energy_model.disc_radius_m), most_m_(energy_model.disc_radius_m) {
    if (!(energy_model.disc_radius_m > 0)) throw MismatchError("the energy model has no disc");
    const DiscSizes& sizes = energy_model.sizes.empty() ? energy_model.disc.sizes : energy_model.sizes;
    const Eigen::VectorXd& known = sizes.radii_m;
    if (known.size() == 0) return;
    spacing_m_ = sizes.spacing_m;
    const auto at = [&](const std::vector<std::string>& terms) { return resized(energy_model.patch, terms, energy_model.coefficients, own_m_, spacing_m_, 1).log_N_m.col(0).eval(); };
    learned_ = at(energy_model.terms) - at({});
    own_start_ = start_of_disc(1, own_m_, spacing_m_) + learned(own_m_) * learned_;
    least_m_ = known[0];
    most_m_ = known[known.size() - 1];
}

}  // namespace tissue
