#pragma once

#include <algorithm>
#include <cmath>

#include "springs/tissue_model.h"

namespace tissue {

/// A disc's contact stiffnesses at any radius, without an allocation: between the discs that a law was trained under as the law has them (energy_law.h, resized), beyond them as on a half space. What the
/// law has learned of the radius fades out over a fifth of its logarithm, so that this makes no step of the force of a contact that grows (corrections for the lattice, DiscSizes, are linear between radii, and make small ones).
class PatchSizes {
   public:
    PatchSizes() = default;
    /// Throws MismatchError for a law that has no disc.
    explicit PatchSizes(const LawModel& law);

    PatchLaw at(double radius_m) const noexcept {
        PatchLaw law = own_;
        law.log_N_m.col(0) += std::log(radius_m / own_m_) * half_space_ + (learned(radius_m) - learned(own_m_)) * learned_;
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

    using Rows = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, PatchLaw::disc_rows, 1>;
    PatchLaw own_;
    Rows half_space_, learned_;  ///< d log_N_m(m, 0) / d log radius: of a half space, and what terms `size` add
    double own_m_ = 1, least_m_ = 1, most_m_ = 1;
};

}  // namespace tissue
