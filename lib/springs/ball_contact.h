#pragma once

#include <algorithm>
#include <cmath>

namespace tissue {

/// Contact of a rigid ball with a surface (Hertz; Johnson, Contact Mechanics, 4.2). The contact is a circle of radius
/// a, which grows with the penetration depth d:
///   a = sqrt(R_e d) (1 - d / (14 R_e)),  1 / R_e = 1 / R + H,
/// where R is the ball's radius and H the surface's mean curvature [1/m], positive where the surface bulges.
/// A disc of radius a(d) (springs/disc_contact.h) then stores on a half space the energy that a sphere stores (Sneddon
/// 1965): the force agrees within 0.1 % up to d = R_e, where half of the ball is in the tissue.
/// Beyond d = R_e the radius tends smoothly to 9/8 R_e. That part was compared with nothing.
struct BallContact {
    double radius_m;

    static constexpr double half_in = 13.0 / 14;       ///< a / R_e at d = R_e
    static constexpr double slope = 11.0 / 28;         ///< da / dd at d = R_e
    static constexpr double beyond = 0.5;              ///< decay depth of da / dd beyond d = R_e, over R_e
    /// largest R_e / R: a more concave surface is treated as one with this ratio
    static constexpr double hollow = 1.2;
    static constexpr double largest = hollow * (half_in + beyond * slope);  ///< largest a / R

    double effective_m(double curvature_1_m) const noexcept { return 1 / std::max(1 / radius_m + curvature_1_m, 1 / (hollow * radius_m)); }

    /// Contact radius a [m] at a penetration depth [m]; 0 for a depth that is not positive.
    static double contact_m(double effective_m, double depth_m) noexcept {
        const double x = depth_m / effective_m;
        if (!(x > 0)) return 0;
        return effective_m * (x <= 1 ? std::sqrt(x) * (1 - x / 14) : half_in + beyond * slope * -std::expm1((1 - x) / beyond));
    }
    /// Part of the tool's displacement along the surface that stretches the contact: (1 / a) int a dd / d. It holds
    /// where the ball moves on a straight line and each ring of the contact is bound where it forms.
    static double bound_part(double effective_m, double depth_m) noexcept {
        const double x = std::min(depth_m / effective_m, 1.0);
        return (2.0 / 3 - x / 35) / (1 - x / 14);
    }
    /// da / dd; depth_m > 0.
    static double growth(double effective_m, double depth_m) noexcept {
        const double x = depth_m / effective_m;
        return x <= 1 ? 0.5 / std::sqrt(x) - 3.0 / 28 * std::sqrt(x) : slope * std::exp((1 - x) / beyond);
    }
};

}  // namespace tissue
