#pragma once

#include <Eigen/Core>

#include "haptic/device.h"

namespace tissue {

struct SafetyOptions {
    double dt_s = 1e-3;             ///< 1 kHz
    double force_max_N = 3.3;       ///< a Touch, and its predecessor the PHANTOM Omni: 3.3 N at its nominal position
    double slew_N_s = 500;          ///< half a newton a tick: full force after 7 ms
    double speed_max_m_s = 2;       ///< of the master; hands at work stay below about 1 m/s
    double stale_s = 0.05;          ///< oldest position that still counts
    bool passivity = true;
    double damping_max_Ns_m = 3;    ///< most that the passivity controller injects; 1 kHz devices carry a few Ns/m
};

struct SafetyCounters {
    long long bad_input = 0;   ///< not finite, or the device reported an error
    long long jump = 0;        ///< master moved by more than speed_max in one tick
    long long stale = 0;       ///< position too old
    long long clamped = 0;     ///< wanted force above force_max
    long long slewed = 0;      ///< change of force cut to slew
    long long damped = 0;      ///< passivity controller at work
    double force_max_N = 0;    ///< largest force that went out
    double energy_given_J = 0; ///< to the hand since the start, over all measured motion; negative: the hand gave
};

/// The last stage of a tick, at the device's port. A force goes out only finite and within force_max, changes by at
/// most slew a tick, and keeps the port passive: a time-domain passivity observer and controller after Hannaford and
/// Ryu (IEEE Trans. Robotics and Automation 18(1), 2002). A force F is held for one tick while the hand moves by
/// dx, so the port gives exactly F dx.
///
/// Energy given is at most energy taken plus force_max * speed_max * dt at every tick, by construction: the
/// controller damps as soon as the observer E shows a surplus, and the force is also capped at
/// force_max - E / (speed_max dt), so that the worst motion of the next tick cannot pass the bound. The motion of a
/// fault, which nobody measured, is not counted. Credit is forgotten when contact ends, debt is not.
class Safety {
   public:
    explicit Safety(const SafetyOptions& options) : o_(options) {}

    /// Looks at a new sample before anything uses it, and books the energy of the tick behind. False: a fault, counted
    /// once by its kind; stop() must follow. elapsed_s: since the last call (ticks that were missed make it longer).
    bool admit(const DeviceSample& sample, double elapsed_s) noexcept;

    /// The force that may go out instead of the wanted one [N]. Not finite counts as nothing wanted.
    Eigen::Vector3d limit(const Eigen::Vector3d& wanted_N) noexcept;

    /// Zero now, whatever slew says.
    Eigen::Vector3d stop() noexcept;

    /// Contact has ended: what the hand gave before does not entitle the next contact to give it back.
    void forget_credit() noexcept {
        if (observed_J_ < 0) observed_J_ = 0;
    }

    const SafetyCounters& counters() const { return counters_; }
    const Eigen::Vector3d& force_N() const { return force_N_; }
    double observed_J() const { return observed_J_; }
    double bound_J() const { return o_.force_max_N * o_.speed_max_m_s * o_.dt_s; }

   private:
    SafetyOptions o_;
    SafetyCounters counters_;
    Eigen::Vector3d force_N_ = Eigen::Vector3d::Zero();     ///< that went out last
    Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero();  ///< last good one
    Eigen::Vector3d motion_m_ = Eigen::Vector3d::Zero();    ///< of the tick behind
    bool has_position_ = false;
    double since_good_s_ = 0;
    double observed_J_ = 0;                                 ///< E: energy given, credit of ended contacts left out
};

}  // namespace tissue
