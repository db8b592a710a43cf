#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "springs/disc_rows.h"
#include "springs/tissue_model.h"

namespace tissue {

/// A disc's contact stiffnesses at any radius, without an allocation: between the discs that a law was trained under as the law has them (energy_law.h, resized), beyond them as rows start (springs/disc_rows.h). What the
/// law has learned of the radius fades out over a fifth of its logarithm, so that this makes no step of the force of a contact that grows. Two other things make small ones: corrections for the lattice (DiscSizes) are linear between radii, and the mean begins to grow with the disc at R = 1.07 edges.
class PatchSizes {
   public:
    PatchSizes() = default;
    /// Throws MismatchError for a law that has no disc. Of a law that knows one disc alone `at` may not be asked (NaN).
    explicit PatchSizes(const LawModel& law);

    PatchLaw at(double radius_m) const noexcept {
        PatchLaw law = own_;
        law.log_N_m.col(0) += start_of_disc(1, radius_m, spacing_m_) + learned(radius_m) * learned_ - own_start_;
        return law;
    }
    double least_m() const { return least_m_; }
    double most_m() const { return most_m_; }

   private:
    /// Logarithm of the radius that what was learned goes by.
    double learned(double radius_m) const noexcept {
        constexpr double fades = 0.2;
        const double known_m = std::min(std::max(radius_m, least_m_), most_m_), beyond = std::log(radius_m / known_m), part = std::min(std::abs(beyond), fades);
        return std::log(known_m) + std::copysign(part - part * part / (2 * fades), beyond);
    }

    PatchLaw own_;
    PatchLaw::Start learned_ = PatchLaw::Start::Zero(), own_start_ = learned_;  ///< d log_N_m(m, 0) / d log radius of what terms `size` add, and what `at` adds before own_start_ is taken off at the law's own radius
    double own_m_ = 1, spacing_m_ = std::numeric_limits<double>::quiet_NaN(), least_m_ = 1, most_m_ = 1;
};

}  // namespace tissue
