#pragma once

#include <algorithm>
#include <cmath>

#include "springs/two_node_law.h"

namespace tissue {

constexpr double no_length_m = 1e-12;  ///< two nodes on one spot have no direction to push in

/// A spring along its current direction, which turns with the tissue. Stretch, all static, says how hard it pulls per
/// unit stiffness, of its rest length and its length [m]; its slope at rest is 1, so that theta means the same in every
/// law:
///   name, stiffest
///   secant   force over current length: the force is secant * (x_i - x_j)
///   tangent  d force / d length
///   energy   [m^2], 0 at rest
///   pull     the law's kernel: `turning` below, built for wide registers (a template cannot be)
template <class Stretch>
struct Turning : Stretch {
    static constexpr bool linear = false, axes_apart = false;

    template <class Vector>
    static Vector force(const Vector& rest, const Vector& relative) {
        const Vector current = rest + relative;
        return current * Stretch::secant(rest.norm(), std::max(current.norm(), no_length_m));
    }
    template <class Vector>
    static SquareOf<Vector> stiffness(const Vector& rest, const Vector& relative, bool convex) {
        const Vector current = rest + relative;
        const double length = current.norm();
        const SquareOf<Vector> identity = SquareOf<Vector>::Identity(rest.size(), rest.size());
        if (!(length > no_length_m)) return identity;
        const SquareOf<Vector> along = current * current.transpose() / (length * length);
        const double across = Stretch::secant(rest.norm(), length);
        return Stretch::tangent(rest.norm(), length) * along + (convex ? std::max(across, 0.0) : across) * (identity - along);
    }
    template <class Vector>
    static double energy(const Vector& rest, const Vector& relative) {
        return Stretch::energy(rest.norm(), (rest + relative).norm());
    }
};

namespace kernel {

template <class Stretch>
inline void turning(const SpringRun& r, int n, double* __restrict gx, double* __restrict gy) {
    for (int k = 0; k < n; ++k) {
        const double x = r.sx[k] + (r.ux_j[k] - r.ux_i[k]), y = r.sy[k] + (r.uy_j[k] - r.uy_i[k]);
        const double pull = r.theta[k] * Stretch::secant(r.length[k], std::max(std::sqrt(x * x + y * y), no_length_m));
        gx[k] = pull * x;
        gy[k] = pull * y;
    }
}

}  // namespace kernel
}  // namespace tissue
