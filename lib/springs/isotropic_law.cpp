#include "hot_loop.h"
#include "springs/two_node_law.h"

namespace tissue {
namespace kernel {

TISSUE_HOT void isotropic(const SpringRun& r, int n, double* __restrict gx, double* __restrict gy) {
    for (int k = 0; k < n; ++k) {
        gx[k] = r.theta[k] * (r.ux_j[k] - r.ux_i[k]);
        gy[k] = r.theta[k] * (r.uy_j[k] - r.uy_i[k]);
    }
}

}  // namespace kernel

namespace {

/// theta (u_i - u_j): the same in every direction, so no 4-connected row can slide for nothing.
struct Isotropic {
    static constexpr const char* name = "isotropic";
    static constexpr bool linear = true, axes_apart = true;

    template <class Vector>
    static Vector force(const Vector&, const Vector& relative) {
        return relative;
    }
    template <class Vector>
    static SquareOf<Vector> stiffness(const Vector& rest, const Vector&, bool) {
        return SquareOf<Vector>::Identity(rest.size(), rest.size());
    }
    template <class Vector>
    static double energy(const Vector&, const Vector& relative) {
        return relative.squaredNorm() / 2;
    }
    static void pull(const SpringRun& run, int n, double* gx, double* gy) noexcept { kernel::isotropic(run, n, gx, gy); }
};

}  // namespace

std::unique_ptr<SpringLaw> make_isotropic_law() { return std::make_unique<TwoNodeLaw<Isotropic>>(); }

}  // namespace tissue
