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
    static constexpr bool linear = false, axes_apart = false;

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
    static void pull(const SpringRun& run, int n, double* gx, double* gy) noexcept;
};

}  // namespace

namespace kernel {

/// 1 / sqrt(x) to the last bits, in additions and products alone: where registers are wide, a root and a division take three
/// times as long. The exponent halved by an integer's shift is 3.5 % off at most; with e = 1 - x y^2 the series of
/// (1 - e)^(-1/2) then leaves 4e-7, and its first terms again less than rounding.
inline double inverse_root(double x) {
    std::int64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    bits = 0x5fe6eb50c7b537a9 - (bits >> 1);
    double y;
    std::memcpy(&y, &bits, sizeof y);
    double e = 1 - x * y * y;
    y += y * e * (0.5 + e * (0.375 + e * (0.3125 + e * 0.2734375)));
    e = 1 - x * y * y;
    return y + y * e * (0.5 + e * 0.375);
}

/// Hookean::force of many springs, by inverse length.
TISSUE_HOT void geometric(const SpringRun& r, int n, double* __restrict gx, double* __restrict gy) {
    for (int k = 0; k < n; ++k) {
        const double x = r.sx[k] + (r.ux_j[k] - r.ux_i[k]), y = r.sy[k] + (r.uy_j[k] - r.uy_i[k]);
        const double pull = r.theta[k] * (1 - r.length[k] * inverse_root(std::max(x * x + y * y, no_length_m * no_length_m)));
        gx[k] = pull * x;
        gy[k] = pull * y;
    }
}

}  // namespace kernel

void Hookean::pull(const SpringRun& run, int n, double* gx, double* gy) noexcept { kernel::geometric(run, n, gx, gy); }

std::unique_ptr<SpringLaw> make_geometric_law() { return std::make_unique<TwoNodeLaw<Hookean>>(); }

}  // namespace tissue
