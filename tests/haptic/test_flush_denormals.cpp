// Denormals: the floating-point mode of a tick, decaying oscillations of tissue, and the caller's mode afterwards.
#include "flush_denormals.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../example.h"
#include "../float_mode.h"
#include "haptic/simulation.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

long denormals(const NodeColumns& values) {
    long count = 0;
    for (double v : values.reshaped()) count += std::fpclassify(v) == FP_SUBNORMAL;
    return count;
}

long denormals(const Simulation& s) {
    long count = 0;
    for (std::size_t m = 0; m < s.model().meshes.size(); ++m) count += denormals(s.state(m).displacement) + denormals(s.state(m).velocity) + denormals(s.state(m).acceleration);
    return count;
}

}  // namespace

TEST_CASE("FlushDenormals sets denormals to zero and rounding to nearest and restores the caller's mode", "[denormals]") {
    std::fenv_t before;
    std::fegetenv(&before);
    for (int rounding : {FE_TONEAREST, FE_UPWARD, FE_TOWARDZERO}) {
        std::fesetround(rounding);
        const FloatMode mine = float_mode();
        FloatMode within;
        bool on;
        {
            const FlushDenormals flush;
            on = FlushDenormals::on();
            within = float_mode();
            const FlushDenormals twice;
        }
        const FloatMode after = float_mode();
        const bool off = !FlushDenormals::on();
        std::fesetenv(&before);
        CHECK(after == mine);
        CHECK(mine.denormals);
#if defined(__x86_64__) || defined(__aarch64__)
        CHECK(on);
        CHECK(off);
        CHECK_FALSE(within.denormals);
        CHECK(within.rounding == 0);
#endif
    }
}

#if defined(__x86_64__) || defined(__aarch64__)
TEST_CASE("decaying oscillations of tissue produce no denormal values and ticks keep the caller's floating-point mode", "[denormals][simulation]") {
    struct Kind { const char *name, *dynamics; TissueModel model; };
    const ExampleModel paper{"grid4", "isotropic"};
    for (const Kind& kind : {Kind{"spring sets", "auto", haptic_example(paper)}, Kind{"spring sets, paper", "paper", haptic_example(paper)}, Kind{"spring sets, implicit", "implicit", haptic_example(paper)},
                             Kind{"energy model", "auto", energy_model_example()}, Kind{"energy model that relaxes", "auto", relaxing(energy_model_example())}, Kind{"energy model in space", "auto", solid_example()}}) {
        INFO(kind.name);
        HapticOptions o;
        o.dynamics = kind.dynamics;
        o.heuristic_mesh = false;
        const HapticModel model(kind.model, o);
        Simulation s(model);
        // As after minutes without contact: velocities near the smallest normal number, and those of some seconds
        // earlier.
        for (int n = 0; n < model.rest.node_count(); ++n)
            if (!model.meshes[0]->springs.fixed(n)) s.state(0).velocity.row(n).setConstant(std::pow(10, -300 - n % 8));
        const DeviceSample away = sample_at(Eigen::Vector3d(0.05, 0.3, 0.3));
        const FloatMode mine = float_mode();
        long seen = 0;
        bool moved = false, same = true;
        for (int k = 0; k < 3000; ++k) {
            s.tick(away);
            same &= float_mode() == mine;
            seen += denormals(s);
            moved |= !s.state(0).displacement.isZero(0) || !s.state(0).velocity.isZero(0);
        }
        CHECK(same);
        CHECK(moved);
        CHECK(seen == 0);
    }
}
#endif
