#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "springs/disc_rows.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Contact parameters of a disc as a function of its radius, without allocation. Between the smallest and the largest
/// training disc they are those of resized() (energy_model.h). Beyond them they follow their analytical start
/// (springs/disc_rows.h). There the trained dependence on the radius fades out over 0.2 in log radius, so that the
/// force of a growing contact does not jump.
/// Two other effects cause small jumps of that force: lattice corrections (DiscSizes) are piecewise linear in log
/// radius, and the mean's reach starts to grow with the disc at R = 1.07 cube edges.
class PatchSizes {
   public:
    PatchSizes() = default;
    /// Throws MismatchError for an energy model without a disc. For one with a single disc radius, at() returns NaN and
    /// must not be called.
    explicit PatchSizes(const EnergyModel& energy_model);

    ContactParameters at(double radius_m) const noexcept {
        ContactParameters law = own_;
        law.log_N_m.col(0) += start_of_disc(1, radius_m, spacing_m_) + learned(radius_m) * learned_ - own_start_;
        return law;
    }
    double least_m() const { return least_m_; }
    double most_m() const { return most_m_; }

   private:
    /// Log radius for the trained dependence: that of radius_m within the training range, constant beyond the fade-out.
    double learned(double radius_m) const noexcept {
        constexpr double fades = 0.2;
        const double known_m = std::min(std::max(radius_m, least_m_), most_m_), beyond = std::log(radius_m / known_m), part = std::min(std::abs(beyond), fades);
        return std::log(known_m) + std::copysign(part - part * part / (2 * fades), beyond);
    }

    ContactParameters own_;
    /// learned_: trained slope d log_N_m(m, 0) / d log radius of the terms `size`. own_start_: what at() adds at the
    /// model's own radius, and subtracts
    ContactParameters::Start learned_ = ContactParameters::Start::Zero(), own_start_ = learned_;
    double own_m_ = 1, spacing_m_ = std::numeric_limits<double>::quiet_NaN(), least_m_ = 1, most_m_ = 1;
};

}  // namespace tissue
