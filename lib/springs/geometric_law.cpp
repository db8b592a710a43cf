#include <algorithm>
#include <cstdint>
#include <cstring>

#include "hot_loop.h"
#include "springs/two_node_law.h"

namespace tissue {
namespace {

constexpr double no_length_m = 1e-12;  ///< two nodes on one spot have no direction to push in

/// theta (|x_i - x_j| - L0) along the current direction: Hooke's spring, turning with the tissue.
struct Hookean {
    static constexpr const char* name = "geometric";
    static constexpr bool linear = false, axes_apart = false, in_space = true;

    /// Force over current length: the force is that times (x_i - x_j).
    static double secant(double rest, double length) noexcept { return 1 - rest / length; }

    template <class Vector>
    static Vector force(const Vector& rest, const Vector& relative) {
        const Vector current = rest + relative;
        return current * secant(rest.norm(), std::max(current.norm(), no_length_m));
    }
    template <class Vector>
    static SquareOf<Vector> stiffness(const Vector& rest, const Vector& relative, bool convex) {
        const Vector current = rest + relative;
        const double length = current.norm();
        const SquareOf<Vector> identity = SquareOf<Vector>::Identity(rest.size(), rest.size());
        if (!(length > no_length_m)) return identity;
        const SquareOf<Vector> along = current * current.transpose() / (length * length);
        const double across = secant(rest.norm(), length);
        return along + (convex ? std::max(across, 0.0) : across) * (identity - along);
    }
    template <class Vector>
    static double energy(const Vector& rest, const Vector& relative) {
        const double by = (rest + relative).norm() - rest.norm();
        return by * by / 2;
    }
    static void pull(const SpringRun& run, int n) noexcept;
};

}  // namespace

namespace kernel {

/// 1 / sqrt(x) to the last bits, in additions and products alone: where registers are wide, a root and a division take three
/// times as long. The exponent halved by an integer's shift is 3.5 % off at most; with e = 1 - x y^2 the series of
/// (1 - e)^(-1/2) then leaves 4e-7, and its first terms again less than rounding.
inline double inverse_root(double x) {
    std::uint64_t bits;  // unsigned: AVX2 has no shift of 64 bits that keeps a sign
    std::memcpy(&bits, &x, sizeof bits);
    bits = 0x5fe6eb50c7b537a9 - (bits >> 1);
    double y;
    std::memcpy(&y, &bits, sizeof y);
    double e = 1 - x * y * y;
    y += y * e * (0.5 + e * (0.375 + e * (0.3125 + e * 0.2734375)));
    e = 1 - x * y * y;
    return y + y * e * (0.5 + e * 0.375);
}

/// no_length_m squared, as no constant: loops take a copy. Of a constant gcc makes a branch with its root, and then loops for all but the widest
/// registers (AVX-512) one by one.
double least_squared_m2 = no_length_m * no_length_m;

/// Hookean::secant, times theta, by the squared length.
inline double secant(double theta, double rest, double squared, double least) {
    return theta * (1 - rest * inverse_root(std::max(squared, least)));
}

/// Hookean::force of many springs, in the plane.
TISSUE_HOT void geometric(const SpringRun& r, int n, double* __restrict fx_i, double* __restrict fy_i, double* __restrict fx_j,
                          double* __restrict fy_j) {
    const double least = least_squared_m2;
    for (int k = 0; k < n; ++k) {
        const double x = r.span[0][k] + (r.u_j[0][k] - r.u_i[0][k]), y = r.span[1][k] + (r.u_j[1][k] - r.u_i[1][k]);
        const double pull = secant(r.theta[k], r.length[k], x * x + y * y, least);
        fx_i[k] -= pull * x;
        fy_i[k] -= pull * y;
        fx_j[k] += pull * x;
        fy_j[k] += pull * y;
    }
}

/// Of springs that are alike at rest: nothing of that is read from memory.
TISSUE_HOT void geometric_alike(const SpringRun& r, int n, double sx, double sy, double length, double* __restrict fx_i,
                                double* __restrict fy_i, double* __restrict fx_j, double* __restrict fy_j) {
    const double least = least_squared_m2;
    for (int k = 0; k < n; ++k) {
        const double x = sx + (r.u_j[0][k] - r.u_i[0][k]), y = sy + (r.u_j[1][k] - r.u_i[1][k]);
        const double pull = secant(r.theta[k], length, x * x + y * y, least);
        fx_i[k] -= pull * x;
        fy_i[k] -= pull * y;
        fx_j[k] += pull * x;
        fy_j[k] += pull * y;
    }
}

/// Both in space.
TISSUE_HOT void geometric_solid(const SpringRun& r, int n, double* __restrict fx_i, double* __restrict fy_i, double* __restrict fz_i,
                                double* __restrict fx_j, double* __restrict fy_j, double* __restrict fz_j) {
    const double least = least_squared_m2;
    for (int k = 0; k < n; ++k) {
        const double x = r.span[0][k] + (r.u_j[0][k] - r.u_i[0][k]), y = r.span[1][k] + (r.u_j[1][k] - r.u_i[1][k]),
                     z = r.span[2][k] + (r.u_j[2][k] - r.u_i[2][k]);
        const double pull = secant(r.theta[k], r.length[k], x * x + y * y + z * z, least);
        fx_i[k] -= pull * x;
        fy_i[k] -= pull * y;
        fz_i[k] -= pull * z;
        fx_j[k] += pull * x;
        fy_j[k] += pull * y;
        fz_j[k] += pull * z;
    }
}

TISSUE_HOT void geometric_solid_alike(const SpringRun& r, int n, double sx, double sy, double sz, double length, double* __restrict fx_i,
                                      double* __restrict fy_i, double* __restrict fz_i, double* __restrict fx_j, double* __restrict fy_j,
                                      double* __restrict fz_j) {
    const double least = least_squared_m2;
    for (int k = 0; k < n; ++k) {
        const double x = sx + (r.u_j[0][k] - r.u_i[0][k]), y = sy + (r.u_j[1][k] - r.u_i[1][k]), z = sz + (r.u_j[2][k] - r.u_i[2][k]);
        const double pull = secant(r.theta[k], length, x * x + y * y + z * z, least);
        fx_i[k] -= pull * x;
        fy_i[k] -= pull * y;
        fz_i[k] -= pull * z;
        fx_j[k] += pull * x;
        fy_j[k] += pull * y;
        fz_j[k] += pull * z;
    }
}

/// Current spans and one over their lengths, and how far springs are drawn out. In the plane.
TISSUE_HOT void drawn_out(const SpringRun& r, int n, double* __restrict x, double* __restrict y, double* __restrict inverse, double* __restrict by) {
    const double least = least_squared_m2;
    for (int k = 0; k < n; ++k) {
        x[k] = r.span[0][k] + (r.u_j[0][k] - r.u_i[0][k]);
        y[k] = r.span[1][k] + (r.u_j[1][k] - r.u_i[1][k]);
        const double squared = std::max(x[k] * x[k] + y[k] * y[k], least);
        inverse[k] = inverse_root(squared);
        by[k] = squared * inverse[k] - r.length[k];
    }
}

TISSUE_HOT void drawn_out_alike(const SpringRun& r, int n, double sx, double sy, double length, double* __restrict x, double* __restrict y,
                                double* __restrict inverse, double* __restrict by) {
    const double least = least_squared_m2;
    for (int k = 0; k < n; ++k) {
        x[k] = sx + (r.u_j[0][k] - r.u_i[0][k]);
        y[k] = sy + (r.u_j[1][k] - r.u_i[1][k]);
        const double squared = std::max(x[k] * x[k] + y[k] * y[k], least);
        inverse[k] = inverse_root(squared);
        by[k] = squared * inverse[k] - length;
    }
}

/// Both in space.
TISSUE_HOT void drawn_out_solid(const SpringRun& r, int n, double* __restrict x, double* __restrict y, double* __restrict z, double* __restrict inverse,
                                double* __restrict by) {
    const double least = least_squared_m2;
    for (int k = 0; k < n; ++k) {
        x[k] = r.span[0][k] + (r.u_j[0][k] - r.u_i[0][k]);
        y[k] = r.span[1][k] + (r.u_j[1][k] - r.u_i[1][k]);
        z[k] = r.span[2][k] + (r.u_j[2][k] - r.u_i[2][k]);
        const double squared = std::max(x[k] * x[k] + y[k] * y[k] + z[k] * z[k], least);
        inverse[k] = inverse_root(squared);
        by[k] = squared * inverse[k] - r.length[k];
    }
}

TISSUE_HOT void drawn_out_solid_alike(const SpringRun& r, int n, double sx, double sy, double sz, double length, double* __restrict x,
                                      double* __restrict y, double* __restrict z, double* __restrict inverse, double* __restrict by) {
    const double least = least_squared_m2;
    for (int k = 0; k < n; ++k) {
        x[k] = sx + (r.u_j[0][k] - r.u_i[0][k]);
        y[k] = sy + (r.u_j[1][k] - r.u_i[1][k]);
        z[k] = sz + (r.u_j[2][k] - r.u_i[2][k]);
        const double squared = std::max(x[k] * x[k] + y[k] * y[k] + z[k] * z[k], least);
        inverse[k] = inverse_root(squared);
        by[k] = squared * inverse[k] - length;
    }
}

/// pull = theta inverse by, in place of inverse.
TISSUE_HOT void pull_of(int n, const double* __restrict theta, const double* __restrict by, double* __restrict inverse) {
    for (int k = 0; k < n; ++k) inverse[k] *= theta[k] * by[k];
}

/// f_i -= pull x, f_j += pull x, one axis.
TISSUE_HOT void put_on_ends(int n, const double* __restrict pull, const double* __restrict x, double* __restrict f_i, double* __restrict f_j) {
    for (int k = 0; k < n; ++k) {
        const double g = pull[k] * x[k];
        f_i[k] -= g;
        f_j[k] += g;
    }
}

}  // namespace kernel

namespace {

constexpr int chunk = 256;

/// Springs that relax pull with what their memory makes of how far they are drawn out.
void pull_with_memory(const SpringRun& r, int n) noexcept {
    alignas(64) double span[3][chunk], inverse[chunk], by[chunk], felt[chunk];
    if (r.dimension == 2 && r.alike)
        kernel::drawn_out_alike(r, n, r.one_span[0], r.one_span[1], r.one_length, span[0], span[1], inverse, by);
    else if (r.dimension == 2)
        kernel::drawn_out(r, n, span[0], span[1], inverse, by);
    else if (r.alike)
        kernel::drawn_out_solid_alike(r, n, r.one_span[0], r.one_span[1], r.one_span[2], r.one_length, span[0], span[1], span[2], inverse, by);
    else
        kernel::drawn_out_solid(r, n, span[0], span[1], span[2], inverse, by);
    r.memory->step(r.first, n, by, felt);
    kernel::pull_of(n, r.theta, felt, inverse);
    for (int d = 0; d < r.dimension; ++d) kernel::put_on_ends(n, inverse, span[d], r.f_i[d], r.f_j[d]);
}

}  // namespace

void Hookean::pull(const SpringRun& r, int n) noexcept {
    if (r.memory) return pull_with_memory(r, n);
    if (r.dimension == 2 && r.alike)
        kernel::geometric_alike(r, n, r.one_span[0], r.one_span[1], r.one_length, r.f_i[0], r.f_i[1], r.f_j[0], r.f_j[1]);
    else if (r.dimension == 2)
        kernel::geometric(r, n, r.f_i[0], r.f_i[1], r.f_j[0], r.f_j[1]);
    else if (r.alike)
        kernel::geometric_solid_alike(r, n, r.one_span[0], r.one_span[1], r.one_span[2], r.one_length, r.f_i[0], r.f_i[1], r.f_i[2], r.f_j[0],
                                      r.f_j[1], r.f_j[2]);
    else
        kernel::geometric_solid(r, n, r.f_i[0], r.f_i[1], r.f_i[2], r.f_j[0], r.f_j[1], r.f_j[2]);
}

std::unique_ptr<SpringLaw> make_geometric_law() { return std::make_unique<TwoNodeLaw<Hookean>>(); }

}  // namespace tissue
