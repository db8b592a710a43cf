#pragma once

#include <algorithm>

namespace tissue {

/// How a spring that turns with the tissue answers to its stretch lambda = length / rest length, per unit stiffness
/// theta [N/m]. Every answer has slope 1 at rest, so theta means the same in all of them. Lengths in metres; inline,
/// because the 1 kHz kernels use them too.
///   secant   force over current length: the force is secant * (x_i - x_j)
///   tangent  d force / d length
///   energy   [m^2], 0 at rest

/// Hooke's: elongation times theta.
struct HookeanStretch {
    static constexpr double stiffest = 1;  ///< no tangent is above it
    static double secant(double rest, double length) noexcept { return 1 - rest / length; }
    static double tangent(double, double) noexcept { return 1; }
    static double energy(double rest, double length) noexcept { return (length - rest) * (length - rest) / 2; }
};

/// A rod of incompressible neo-Hookean material: (lambda - lambda^-2) / 3 of its rest length, softer when pulled and
/// stiffer when pressed. Below half its length it keeps the tangent it has there, so that no spring is infinitely
/// stiff. Source: uniaxial stress of the paper's (3) with C2 = 0.
struct RubberStretch {
    static constexpr double stiffest = (1 + 2 * 8.0) / 3;
    static double secant(double rest, double length) noexcept {
        const double shortening = rest / std::max(length, rest / 2);  // 1 / lambda, 2 at most
        const double held = (1 - shortening * shortening * shortening) / 3;
        // below half: force = F(1/2) + stiffest (lambda - 1/2), F(1/2) = -7/6
        const double beyond = (-7.0 / 6 - stiffest / 2) * rest / length + stiffest;
        return 2 * length >= rest ? held : beyond;
    }
    static double tangent(double rest, double length) noexcept {
        const double shortening = rest / std::max(length, rest / 2);
        return (1 + 2 * shortening * shortening * shortening) / 3;
    }
    static double energy(double rest, double length) noexcept {
        const double stretch = std::max(length / rest, 0.5), beyond = std::min(length / rest - 0.5, 0.0);
        return rest * rest * ((stretch * stretch / 2 + 1 / stretch - 1.5) / 3 + beyond * (-7.0 / 6 + stiffest * beyond / 2));
    }
};

}  // namespace tissue
