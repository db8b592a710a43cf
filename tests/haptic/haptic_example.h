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
    double spread = 0.5;         ///< difference of the sets from the heuristic and from each other
    double stiffer = 1;          ///< factor on all sets
    double thickness_m = 1.0 / 6000;
};

/// A model like the paper's, in memory and without FE: a square of 10 cm, nine contacts and directions with tool
/// displacements of 10 and 15 mm, a spring set each.
TissueModel haptic_example(const ExampleModel& e = {});

/// An energy model in memory, without FE, on any mesh: near the trained `surface-quick`, 0.1 m thick, with load cases 5
/// and 10 mm deep.
TissueModel energy_model_example(const SpringMesh& mesh = make_lattice("grid8", 10, 10, 0.1, 0.1));

/// The same energy model with three Maxwell branches, whose relative moduli add up to 75 % for every constant and for
/// the contact.
TissueModel relaxing(TissueModel model);

/// Uniform random numbers that are the same on every machine.
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

/// Time to the next tick [s]: on time, late, early, in bursts, and so late that the device has released the force.
class Pace {
   public:
    explicit Pace(unsigned long seed) : draw_(seed) {}
    double next(double dt_s) {
        if (--left_ <= 0) mode_ = draw_.below(5), left_ = 1 + draw_.below(300);
        if (mode_ == 1) return draw_.below(20) ? dt_s : dt_s * draw_(1, 5);                  // sometimes late
        if (mode_ == 2) return dt_s * draw_(0.3, 1.7);                                       // early and late
        if (mode_ == 3) return draw_.below(8) ? dt_s * draw_(0, 0.05) : dt_s * draw_(3, 5);  // a gap, then a burst
        // always late, sometimes very late
        if (mode_ == 4) return draw_.below(30) ? dt_s * draw_(1, 5) : dt_s * draw_(5, 2000);
        return dt_s;
    }

   private:
    Draw draw_;
    int mode_ = 0, left_ = 0;
};

/// Number of adversarial ticks of a test: `usual`, or TISSUE_ADVERSARIAL_TICKS where that is set. Each kind is a
/// section:
/// TISSUE_ADVERSARIAL_TICKS=10000000 test_tissue '[simulation][adversarial]' -c 'NAME'
/// with a NAME such as: grid8 relaxing law auto, force scale 1, on time
long long adversarial_ticks(long long usual);

/// Checks the device's port in every tick: the force is finite and within its limits, and zero at once on a fault. It
/// also computes the energy given to the hand, to be compared with the bound.
class Port {
   public:
    explicit Port(Simulation& simulation) : s_(simulation), o_(simulation.model().options), longest_s_(o_.dt_s) {}

    /// Ticks, and checks. Returns false on a fault, and where a mesh crosses itself or diverged.
    bool tick(const DeviceSample& sample, double elapsed_s);

    double worst_J() const { return worst_J_; }   ///< largest energy given to the hand
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

/// Quantity that slew limits: distance of a force from the nearest k F, F: the force before, 0 <= k <= 1.
inline double rise_N(const Eigen::Vector3d& before_N, const Eigen::Vector3d& now_N) {
    const double square = before_N.squaredNorm(), kept = square > 0 ? std::clamp(now_N.dot(before_N) / square, 0.0, 1.0) : 0;
    return (now_N - kept * before_N).norm();
}
/// Sample at a point in space.
DeviceSample sample_at(const Eigen::Vector3d& place_m);

}  // namespace tissue
