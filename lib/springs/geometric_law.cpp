#include "hot_loop.h"
#include "springs/turning_law.h"

namespace tissue {
namespace {

/// theta (|x_i - x_j| - L0) along the current direction: Hooke's.
struct Hookean {
    static constexpr const char* name = "geometric";
    static constexpr double stiffest = 1;
    static double secant(double rest, double length) noexcept { return 1 - rest / length; }
    static double tangent(double, double) noexcept { return 1; }
    static double energy(double rest, double length) noexcept { return (length - rest) * (length - rest) / 2; }
    static void pull(const SpringRun& run, int n, double* gx, double* gy) noexcept;
};

}  // namespace

namespace kernel {

TISSUE_HOT void geometric(const SpringRun& r, int n, double* __restrict gx, double* __restrict gy) {
    turning<Hookean>(r, n, gx, gy);
}

}  // namespace kernel

void Hookean::pull(const SpringRun& run, int n, double* gx, double* gy) noexcept { kernel::geometric(run, n, gx, gy); }

std::unique_ptr<SpringLaw> make_geometric_law() { return std::make_unique<TwoNodeLaw<Turning<Hookean>>>(); }

}  // namespace tissue
