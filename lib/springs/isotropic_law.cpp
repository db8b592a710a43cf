#include "hot_loop.h"
#include "springs/two_node_law.h"

namespace tissue {
namespace kernel {

TISSUE_HOT void isotropic(int n, const double* __restrict theta, const double* __restrict u_i, const double* __restrict u_j, double* __restrict f_i,
                          double* __restrict f_j) {
    for (int k = 0; k < n; ++k) {
        const double pull = theta[k] * (u_j[k] - u_i[k]);
        f_i[k] -= pull;
        f_j[k] += pull;
    }
}

}  // namespace kernel

namespace {

/// Force theta (u_i - u_j): equal in every direction, so that no row of a 4-connected lattice can slide without energy.
struct Isotropic {
    static constexpr const char* name = "isotropic";
    static constexpr bool linear = true, axes_apart = true, in_space = false, turns = false;

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
    static void pull(const SpringRun& run, int n) noexcept {
        for (int d = 0; d < run.dimension; ++d) kernel::isotropic(n, run.theta, run.u_i[d], run.u_j[d], run.f_i[d], run.f_j[d]);
    }
};

}  // namespace

std::unique_ptr<SpringLaw> make_isotropic_law() { return std::make_unique<TwoNodeLaw<Isotropic>>(); }

}  // namespace tissue
