#include "springs/patch_sizes.h"

#include "error.h"
#include "springs/energy_law.h"

namespace tissue {

PatchSizes::PatchSizes(const LawModel& law) : own_(law.patch), own_m_(law.disc_radius_m), least_m_(law.disc_radius_m), most_m_(law.disc_radius_m) {
    if (!(law.disc_radius_m > 0)) throw MismatchError("the law has no disc");
    half_space_ = resized(law.patch, {}, {}, 1).log_N_m.col(0) - law.patch.log_N_m.col(0);
    learned_ = resized(law.patch, law.terms, law.coefficients, 1).log_N_m.col(0) - law.patch.log_N_m.col(0) - half_space_;
    const Eigen::VectorXd& known = (law.sizes.empty() ? law.disc.sizes : law.sizes).radii_m;
    if (known.size() == 0) return;
    least_m_ = known[0];
    most_m_ = known[known.size() - 1];
}

}  // namespace tissue
