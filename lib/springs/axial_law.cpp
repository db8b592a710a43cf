#include "hot_loop.h"
#include "springs/two_node_law.h"

namespace tissue {
namespace kernel {

TISSUE_HOT void axial(const SpringRun& r, int n, double* __restrict fx_i, double* __restrict fy_i, double* __restrict fx_j,
                      double* __restrict fy_j) {
    for (int k = 0; k < n; ++k) {
        const double nx = r.axis[0][k], ny = r.axis[1][k];
        const double pull = r.theta[k] * (nx * (r.u_j[0][k] - r.u_i[0][k]) + ny * (r.u_j[1][k] - r.u_i[1][k]));
        fx_i[k] -= pull * nx;
        fy_i[k] -= pull * ny;
        fx_j[k] += pull * nx;
        fy_j[k] += pull * ny;
    }
}

/// Springs with one common direction: the axis is not read from memory, whose bandwidth limits large meshes.
TISSUE_HOT void axial_parallel(const SpringRun& r, int n, double nx, double ny, double* __restrict fx_i, double* __restrict fy_i,
                               double* __restrict fx_j, double* __restrict fy_j) {
    for (int k = 0; k < n; ++k) {
        const double pull = r.theta[k] * (nx * (r.u_j[0][k] - r.u_i[0][k]) + ny * (r.u_j[1][k] - r.u_i[1][k]));
        fx_i[k] -= pull * nx;
        fy_i[k] -= pull * ny;
        fx_j[k] += pull * nx;
        fy_j[k] += pull * ny;
    }
}

}  // namespace kernel

namespace {

/// Force theta times the elongation along the rest direction: the spring of linear elasticity.
struct Axial {
    static constexpr const char* name = "axial";
    static constexpr bool linear = true, axes_apart = false, in_space = false, turns = false;

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
    static void pull(const SpringRun& run, int n) noexcept {
        if (run.parallel)
            kernel::axial_parallel(run, n, run.one_axis[0], run.one_axis[1], run.f_i[0], run.f_i[1], run.f_j[0], run.f_j[1]);
        else
            kernel::axial(run, n, run.f_i[0], run.f_i[1], run.f_j[0], run.f_j[1]);
    }
};

}  // namespace

std::unique_ptr<SpringLaw> make_axial_law() { return std::make_unique<TwoNodeLaw<Axial>>(); }

}  // namespace tissue
