#include "hot_loop.h"
#include "springs/turning_law.h"

namespace tissue {
namespace {

/// A rod of incompressible neo-Hookean material along the current direction: theta L0 (lambda - lambda^-2) / 3, with
/// lambda = length / rest length, softer when pulled and stiffer when pressed. Below half its length it keeps the
/// tangent it has there, so that no spring is infinitely stiff. Source: uniaxial stress of the paper's (3) with C2 = 0.
struct NeoHookeanRod {
    static constexpr const char* name = "rubber";
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
    static void pull(const SpringRun& run, int n, double* gx, double* gy) noexcept;
};

}  // namespace

namespace kernel {

TISSUE_HOT void rubber(const SpringRun& r, int n, double* __restrict gx, double* __restrict gy) {
    turning<NeoHookeanRod>(r, n, gx, gy);
}

}  // namespace kernel

void NeoHookeanRod::pull(const SpringRun& run, int n, double* gx, double* gy) noexcept { kernel::rubber(run, n, gx, gy); }

std::unique_ptr<SpringLaw> make_rubber_law() { return std::make_unique<TwoNodeLaw<Turning<NeoHookeanRod>>>(); }

}  // namespace tissue
