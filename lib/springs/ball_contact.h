#pragma once

#include <algorithm>
#include <cmath>

namespace tissue {

/// The contact of a rigid ball with a surface (Hertz; Johnson, Contact Mechanics, 4.2): a circle whose radius a grows with the depth d of the ball,
///   a = sqrt(R_e d) (1 - d / (14 R_e)),  1 / R_e = 1 / R + H, H the surface's mean curvature, positive where it bulges,
/// which stores on a half space what a sphere does (Sneddon 1965): force within 0.1 % up to d = R_e, where half of the ball is in. Deeper it goes over smoothly to 9/8 R_e, as nothing that was compared.
struct BallContact {
    double radius_m;

    static constexpr double half_in = 13.0 / 14;       ///< a / R_e at d = R_e
    static constexpr double slope = 11.0 / 28;         ///< da / dd there
    static constexpr double beyond = 0.5;              ///< in R_e, over which it goes over
    static constexpr double hollow = 1.2;              ///< R_e / R at most: a surface that is more hollow is taken for one that is so hollow
    static constexpr double largest = hollow * (half_in + beyond * slope);  ///< a / R at most

    double effective_m(double curvature_1_m) const noexcept { return 1 / std::max(1 / radius_m + curvature_1_m, 1 / (hollow * radius_m)); }

    /// a at a depth [m]; 0 where there is none.
    static double contact_m(double effective_m, double depth_m) noexcept {
        const double x = depth_m / effective_m;
        if (!(x > 0)) return 0;
        return effective_m * (x <= 1 ? std::sqrt(x) * (1 - x / 14) : half_in + beyond * slope * -std::expm1((1 - x) / beyond));
    }
    /// What of a tool's displacement along the surface stretches the contact, where the ball goes in on a straight way and each ring of the contact is bound where it begins: (1 / a) int a dd / d.
    static double bound_part(double effective_m, double depth_m) noexcept {
        const double x = std::min(depth_m / effective_m, 1.0);
        return (2.0 / 3 - x / 35) / (1 - x / 14);
    }
    /// da / dd at a depth > 0.
    static double growth(double effective_m, double depth_m) noexcept {
        const double x = depth_m / effective_m;
        return x <= 1 ? 0.5 / std::sqrt(x) - 3.0 / 28 * std::sqrt(x) : slope * std::exp((1 - x) / beyond);
    }
};

}  // namespace tissue
