#include "hot_loop.h"
#include "springs/two_node_law.h"

namespace tissue {
namespace kernel {

TISSUE_HOT void axial(const SpringRun& r, int n, double* __restrict gx, double* __restrict gy) {
    for (int k = 0; k < n; ++k) {
        const double pull =
            r.theta[k] * (r.nx[k] * (r.ux_j[k] - r.ux_i[k]) + r.ny[k] * (r.uy_j[k] - r.uy_i[k]));
        gx[k] = pull * r.nx[k];
        gy[k] = pull * r.ny[k];
    }
}

/// Springs of one direction: the axis is not read from memory, which is what large meshes wait for.
TISSUE_HOT void axial_parallel(const SpringRun& r, int n, double nx, double ny, double* __restrict gx,
                               double* __restrict gy) {
    for (int k = 0; k < n; ++k) {
        const double pull = r.theta[k] * (nx * (r.ux_j[k] - r.ux_i[k]) + ny * (r.uy_j[k] - r.uy_i[k]));
        gx[k] = pull * nx;
        gy[k] = pull * ny;
    }
}

}  // namespace kernel

namespace {

/// theta times the elongation along the rest direction: the spring of linear elasticity.
struct Axial {
    static constexpr const char* name = "axial";
    static constexpr bool linear = true, axes_apart = false;

    template <class Vector>
    static Vector force(const Vector& rest, const Vector& relative) {
        return rest * (rest.dot(relative) / rest.squaredNorm());
    }
    template <class Vector>
    static SquareOf<Vector> stiffness(const Vector& rest, const Vector&, bool) {
        return rest * rest.transpose() / rest.squaredNorm();
    }
    template <class Vector>
    static double energy(const Vector& rest, const Vector& relative) {
        const double along = rest.dot(relative);
        return along * along / (2 * rest.squaredNorm());
    }
    static void pull(const SpringRun& run, int n, double* gx, double* gy) noexcept {
        if (run.parallel) kernel::axial_parallel(run, n, run.axis_x, run.axis_y, gx, gy);
        else kernel::axial(run, n, gx, gy);
    }
};

}  // namespace

std::unique_ptr<SpringLaw> make_axial_law() { return std::make_unique<TwoNodeLaw<Axial>>(); }

}  // namespace tissue
