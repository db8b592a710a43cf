#include <algorithm>
#include <cstdint>
#include <cstring>

#include "hot_loop.h"
#include "springs/two_node_law.h"

namespace tissue {
namespace kernel {

/// A SpringCurve as the loops use it. Each loop makes a local copy, so that the compiler knows that no store changes
/// it.
struct Curve {
    double c0, c1, c2, c3, c4, c5, c6;  ///< coefficients of P
    /// beyond this ratio r = L / l (shorter springs) the curve's tangent: secant = slope - offset r
    double most, most_offset;
    double least, least_offset;         ///< the same below this ratio (longer springs)
};

/// The curve with its energy, for springs that relax.
struct RootCurve {
    Curve force;
    double r0, r1, r2, r3, r4, r5;  ///< coefficients of R (SpringCurve::root)
    double most_slope, least_slope;
    /// a slot without a spring has ratio 0, which least_ratio replaces. These are not constants for the reason given at
    /// least_squared_m2
    double least_ratio = 1e-6, none = 0;
};

}  // namespace kernel

namespace {

constexpr double no_length_m = 1e-12;  ///< two nodes at the same place define no direction

/// Force theta (|x_i - x_j| - L0) along the current direction, or that of another SpringCurve: a spring that turns with
/// the tissue.
struct Turning {
    static constexpr const char* name = "geometric";
    static constexpr bool linear = false, axes_apart = false, in_space = true, turns = true;

    SpringCurve of;
    kernel::RootCurve in_loops;

    Turning(const SpringCurve& curve = {});

    template <class Vector>
    static double drawn_out(const Vector& rest, const Vector& current) {
        return std::max(current.norm(), no_length_m) - rest.norm();
    }
    template <class Vector>
    Vector force(const Vector& rest, const Vector& relative) const {
        const Vector current = rest + relative;
        return current * of.secant(rest.norm(), drawn_out(rest, current));
    }
    template <class Vector>
    SquareOf<Vector> stiffness(const Vector& rest, const Vector& relative, bool convex) const {
        const Vector current = rest + relative;
        const double length = current.norm(), by = drawn_out(rest, current);
        const SquareOf<Vector> identity = SquareOf<Vector>::Identity(rest.size(), rest.size());
        if (!(length > no_length_m)) return identity;
        const SquareOf<Vector> direction = current * current.transpose() / (length * length);
        double along = of.slope(rest.norm(), by), across = of.secant(rest.norm(), by);
        if (convex) along = std::max(along, 0.0), across = std::max(across, 0.0);
        return along * direction + across * (identity - direction);
    }
    template <class Vector>
    double energy(const Vector& rest, const Vector& relative) const {
        return of.energy(rest.norm(), drawn_out(rest, Vector(rest + relative)));
    }
    void pull(const SpringRun& run, int n) const noexcept;
};

}  // namespace

namespace kernel {

/// 1 / sqrt(x) to rounding accuracy with additions and products only: in wide registers a root and a division take
/// three times as long. Halving the exponent by an integer shift has an error of at most 3.5 %. With e = 1 - x y^2, the
/// series of (1 - e)^(-1/2) leaves 4e-7. Its first terms, applied again, leave less than rounding.
inline double inverse_root(double x) {
    // unsigned: AVX2 has no arithmetic right shift of 64 bits
    std::uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    bits = 0x5fe6eb50c7b537a9 - (bits >> 1);
    double y;
    std::memcpy(&y, &bits, sizeof y);
    double e = 1 - x * y * y;
    y += y * e * (0.5 + e * (0.375 + e * (0.3125 + e * 0.2734375)));
    e = 1 - x * y * y;
    return y + y * e * (0.5 + e * 0.375);
}

/// no_length_m squared. It is a variable of which loops make a copy: for a constant, gcc makes a branch with its root,
/// and then vectorises the loops only for the widest registers (AVX-512).
double least_squared_m2 = no_length_m * no_length_m;

TISSUE_INLINE double polynomial(double ratio, const Curve& q) {
    return q.c0 + ratio * (q.c1 + ratio * (q.c2 + ratio * (q.c3 + ratio * (q.c4 + ratio * (q.c5 + ratio * q.c6)))));
}

/// theta times SpringCurve::secant. There is no selection between the curve and its tangents, since gcc makes branches
/// of it for all but the widest registers: beyond both ends the secant is linear in the ratio.
TISSUE_INLINE double secant(double theta, double ratio, const Curve& q) {
    const double on_curve = std::min(std::max(ratio, q.least), q.most);
    return theta * ((1 - on_curve) * polynomial(on_curve, q) + q.least_offset * std::max(q.least - ratio, 0.0) - q.most_offset * std::max(ratio - q.most, 0.0));
}

/// Turning::force for many springs, in the plane.
TISSUE_HOT void geometric(const SpringRun& r, const Curve& curve, int n, double* __restrict fx_i, double* __restrict fy_i, double* __restrict fx_j,
                          double* __restrict fy_j) {
    const double least = least_squared_m2;
    const Curve q = curve;
    for (int k = 0; k < n; ++k) {
        const double x = r.span[0][k] + (r.u_j[0][k] - r.u_i[0][k]), y = r.span[1][k] + (r.u_j[1][k] - r.u_i[1][k]);
        const double pull = secant(r.theta[k], r.length[k] * inverse_root(std::max(x * x + y * y, least)), q);
        fx_i[k] -= pull * x;
        fy_i[k] -= pull * y;
        fx_j[k] += pull * x;
        fy_j[k] += pull * y;
    }
}

/// The same for springs with equal rest spans, which are thus not read from memory.
TISSUE_HOT void geometric_alike(const SpringRun& r, const Curve& curve, int n, double sx, double sy, double length, double* __restrict fx_i,
                                double* __restrict fy_i, double* __restrict fx_j, double* __restrict fy_j) {
    const double least = least_squared_m2;
    const Curve q = curve;
    for (int k = 0; k < n; ++k) {
        const double x = sx + (r.u_j[0][k] - r.u_i[0][k]), y = sy + (r.u_j[1][k] - r.u_i[1][k]);
        const double pull = secant(r.theta[k], length * inverse_root(std::max(x * x + y * y, least)), q);
        fx_i[k] -= pull * x;
        fy_i[k] -= pull * y;
        fx_j[k] += pull * x;
        fy_j[k] += pull * y;
    }
}

/// Both in space: geometric() and geometric_alike().
TISSUE_HOT void geometric_solid(const SpringRun& r, const Curve& curve, int n, double* __restrict fx_i, double* __restrict fy_i, double* __restrict fz_i,
                                double* __restrict fx_j, double* __restrict fy_j, double* __restrict fz_j) {
    const double least = least_squared_m2;
    const Curve q = curve;
    for (int k = 0; k < n; ++k) {
        const double x = r.span[0][k] + (r.u_j[0][k] - r.u_i[0][k]), y = r.span[1][k] + (r.u_j[1][k] - r.u_i[1][k]),
                     z = r.span[2][k] + (r.u_j[2][k] - r.u_i[2][k]);
        const double pull = secant(r.theta[k], r.length[k] * inverse_root(std::max(x * x + y * y + z * z, least)), q);
        fx_i[k] -= pull * x;
        fy_i[k] -= pull * y;
        fz_i[k] -= pull * z;
        fx_j[k] += pull * x;
        fy_j[k] += pull * y;
        fz_j[k] += pull * z;
    }
}

TISSUE_HOT void geometric_solid_alike(const SpringRun& r, const Curve& curve, int n, double sx, double sy, double sz, double length, double* __restrict fx_i,
                                      double* __restrict fy_i, double* __restrict fz_i, double* __restrict fx_j, double* __restrict fy_j,
                                      double* __restrict fz_j) {
    const double least = least_squared_m2;
    const Curve q = curve;
    for (int k = 0; k < n; ++k) {
        const double x = sx + (r.u_j[0][k] - r.u_i[0][k]), y = sy + (r.u_j[1][k] - r.u_i[1][k]), z = sz + (r.u_j[2][k] - r.u_i[2][k]);
        const double pull = secant(r.theta[k], length * inverse_root(std::max(x * x + y * y + z * z, least)), q);
        fx_i[k] -= pull * x;
        fy_i[k] -= pull * y;
        fz_i[k] -= pull * z;
        fx_j[k] += pull * x;
        fy_j[k] += pull * y;
        fz_j[k] += pull * z;
    }
}

/// Current spans x, y [m], the inverse of their lengths [1/m], and the elongations `by` [m]. In the plane.
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

/// Both in space: drawn_out() and drawn_out_alike().
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

/// For a spring of energy q^2 / 2 per unit stiffness: by becomes q, and inverse becomes dq/dl over the length. The
/// forces of the branches are thus the derivatives of the energy that they store in terms of q.
TISSUE_HOT void to_root(const RootCurve& curve, int n, double* __restrict inverse, double* __restrict by) {
    constexpr double at_rest = 1e-100;  // avoids 0 / 0 at zero strain
    const RootCurve q = curve;
    for (int k = 0; k < n; ++k) {
        const double ratio = std::max(1 - by[k] * inverse[k], q.least_ratio), on_curve = std::min(std::max(ratio, q.force.least), q.force.most);
        const double stretch = 1 / ratio, at = 1 / on_curve, beyond = stretch - at, shorter = std::min(beyond, q.none), longer = std::max(beyond, q.none);
        // part is 1 on the curve, also at rest
        const double per_strain = 1 / (stretch - 1 + at_rest), part = (at - 1 + at_rest) * per_strain;
        // on the curve: force over strain
        const double pull = polynomial(on_curve, q.force) * part;
        const double w = q.r0 + on_curve * (q.r1 + on_curve * (q.r2 + on_curve * (q.r3 + on_curve * (q.r4 + on_curve * q.r5))));
        const double force = pull + (q.most_slope * shorter + q.least_slope * longer) * per_strain;
        const double here = w * part * part + (2 * pull * beyond + (q.most_slope * shorter * shorter + q.least_slope * longer * longer) * per_strain) * per_strain;
        const double root = inverse_root(here);
        inverse[k] *= force * root;
        by[k] *= here * root;
    }
}

/// inverse becomes theta * inverse * by.
TISSUE_HOT void pull_of(int n, const double* __restrict theta, const double* __restrict by, double* __restrict inverse) {
    for (int k = 0; k < n; ++k) inverse[k] *= theta[k] * by[k];
}

/// f_i -= pull x, f_j += pull x, for one axis.
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

/// Forces of springs that relax: BranchMemory acts on the root of twice the spring's energy, for Hooke's springs the
/// elongation.
void pull_with_memory(const Turning& springs, const SpringRun& r, int n) noexcept {
    alignas(64) double span[3][chunk], inverse[chunk], by[chunk], felt[chunk];
    if (r.dimension == 2 && r.alike)
        kernel::drawn_out_alike(r, n, r.one_span[0], r.one_span[1], r.one_length, span[0], span[1], inverse, by);
    else if (r.dimension == 2)
        kernel::drawn_out(r, n, span[0], span[1], inverse, by);
    else if (r.alike)
        kernel::drawn_out_solid_alike(r, n, r.one_span[0], r.one_span[1], r.one_span[2], r.one_length, span[0], span[1], span[2], inverse, by);
    else
        kernel::drawn_out_solid(r, n, span[0], span[1], span[2], inverse, by);
    if (!springs.of.hookean()) kernel::to_root(springs.in_loops, n, inverse, by);
    r.memory->step(r.first, n, by, felt);
    kernel::pull_of(n, r.theta, felt, inverse);
    for (int d = 0; d < r.dimension; ++d) kernel::put_on_ends(n, inverse, span[d], r.f_i[d], r.f_j[d]);
}

}  // namespace

Turning::Turning(const SpringCurve& curve) : of(curve) {
    const auto& c = of.force();
    const auto& w = of.root();
    in_loops = {{c[0], c[1], c[2], c[3], c[4], c[5], c[6], 1 / of.shorter().stretch, of.shorter().offset(), 1 / of.longer().stretch, of.longer().offset()},
                w[0], w[1], w[2], w[3], w[4], w[5], of.shorter().slope, of.longer().slope};
}

void Turning::pull(const SpringRun& r, int n) const noexcept {
    if (r.memory) return pull_with_memory(*this, r, n);
    const kernel::Curve& q = in_loops.force;
    if (r.dimension == 2 && r.alike)
        kernel::geometric_alike(r, q, n, r.one_span[0], r.one_span[1], r.one_length, r.f_i[0], r.f_i[1], r.f_j[0], r.f_j[1]);
    else if (r.dimension == 2)
        kernel::geometric(r, q, n, r.f_i[0], r.f_i[1], r.f_j[0], r.f_j[1]);
    else if (r.alike)
        kernel::geometric_solid_alike(r, q, n, r.one_span[0], r.one_span[1], r.one_span[2], r.one_length, r.f_i[0], r.f_i[1], r.f_i[2], r.f_j[0],
                                      r.f_j[1], r.f_j[2]);
    else
        kernel::geometric_solid(r, q, n, r.f_i[0], r.f_i[1], r.f_i[2], r.f_j[0], r.f_j[1], r.f_j[2]);
}

std::unique_ptr<SpringLaw> make_geometric_law() { return std::make_unique<TwoNodeLaw<Turning>>(); }

std::unique_ptr<SpringLaw> make_turning_law(const SpringCurve& curve) { return std::make_unique<TwoNodeLaw<Turning>>(Turning(curve)); }

}  // namespace tissue
