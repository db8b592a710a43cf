#pragma once

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "haptic/simulation.h"
#include "springs/tissue_model.h"

namespace tissue {

struct ExampleModel {
    std::string topology = "grid4", law = "isotropic";
    int cells = 10;
    double spread = 0.5;         ///< how much the sets differ from the heuristic, and from each other
    double stiffer = 1;          ///< all sets times this
    double thickness_m = 1.0 / 6000;
};

/// A model as the paper's: 10 cm, 9 pushes at 10 and 15 mm, a spring set each, in memory. No FE in it.
TissueModel haptic_example(const ExampleModel& e = {});

/// A law in memory, on any mesh: near what `surface-quick` learns, 0.1 m thick, with load cases 5 and 10 mm deep. No FE in it.
TissueModel law_example(const SpringMesh& mesh = make_lattice("grid8", 10, 10, 0.1, 0.1));

/// The same law with three branches, 75 % of every constant in them; the contact's too.
TissueModel relaxing(TissueModel law);

/// Uniform numbers that are the same on every machine.
class Draw {
   public:
    explicit Draw(unsigned long seed) : random_(seed) {}
    double operator()(double low, double high) {
        return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1.0p-53;
    }
    int below(int n) { return static_cast<int>(random_() % static_cast<unsigned long>(n)); }

   private:
    std::mt19937_64 random_;
};

/// When the next tick comes [s]: on time, late, early, in bursts, and so late that the device has let go of the force.
class Pace {
   public:
    explicit Pace(unsigned long seed) : draw_(seed) {}
    double next(double dt_s) {
        if (--left_ <= 0) mode_ = draw_.below(5), left_ = 1 + draw_.below(300);
        if (mode_ == 1) return draw_.below(20) ? dt_s : dt_s * draw_(1, 5);                  // a late one now and then
        if (mode_ == 2) return dt_s * draw_(0.3, 1.7);                                       // early and late
        if (mode_ == 3) return draw_.below(8) ? dt_s * draw_(0, 0.05) : dt_s * draw_(3, 5);  // none, then a burst
        if (mode_ == 4) return draw_.below(30) ? dt_s * draw_(1, 5) : dt_s * draw_(5, 2000); // always late, or gone
        return dt_s;
    }

   private:
    Draw draw_;
    int mode_ = 0, left_ = 0;
};

/// How many adversarial ticks a test runs: `usual`, or TISSUE_ADVERSARIAL_TICKS where that is set (10^7 in the issue). Each kind is a
/// section: `TISSUE_ADVERSARIAL_TICKS=10000000 test_tissue '[simulation][adversarial]' -c 'grid8 relaxing law auto, force times 1, on time'`.
long long adversarial_ticks(long long usual);

/// Watches the device's port while it ticks: what goes out is finite and within its limits, zero at once on a fault, and what the
/// hand is given, by its own book, stays below the bound.
class Port {
   public:
    explicit Port(Simulation& simulation) : s_(simulation), o_(simulation.model().options), longest_s_(o_.dt_s) {}

    /// Ticks, and checks. False where there may be no force: a fault, or a mesh without an inside.
    bool tick(const DeviceSample& sample, double elapsed_s);

    double worst_J() const { return worst_J_; }   ///< most that the hand had been given
    double bound_J() const { return longest_s_ / o_.dt_s * s_.safety().bound_J(); }
    long long faults() const { return faults_; }

   private:
    Simulation& s_;
    const HapticOptions& o_;
    Eigen::Vector3d force_N_ = Eigen::Vector3d::Zero(), last_m_ = Eigen::Vector3d::Zero();
    double given_J_ = 0, worst_J_ = 0, longest_s_;
    long long faults_ = 0;
    bool known_ = false;
};

/// Sample at a point of the plane, for the default map.
DeviceSample sample_at(double x_m, double y_m);

/// What slew limits: how far a force has gone from the nearest share of what it was.
inline double rise_N(const Eigen::Vector3d& before_N, const Eigen::Vector3d& now_N) {
    const double square = before_N.squaredNorm(), kept = square > 0 ? std::clamp(now_N.dot(before_N) / square, 0.0, 1.0) : 0;
    return (now_N - kept * before_N).norm();
}
/// In space.
DeviceSample sample_at(const Eigen::Vector3d& place_m);

}  // namespace tissue
