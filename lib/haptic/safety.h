#pragma once

#include <Eigen/Core>

#include "haptic/device.h"
#include "haptic/state_bytes.h"

namespace tissue {

struct SafetyOptions {
    double dt_s = 1e-3;             ///< 1 kHz
    double force_max_N = 3.3;       ///< a Touch, and its predecessor the PHANTOM Omni: 3.3 N at its nominal position
    double slew_N_s = 5000;         ///< force rises by five newtons a tick at most; a rise slower than the tissue's takes less energy than its fall gives
    double speed_max_m_s = 2;       ///< of the master; hands at work stay below about 1 m/s
    double stale_s = 0.05;          ///< oldest position that still counts
    double hold_s = force_held_s;   ///< how long the device holds a force without a new one; infinite: until the next, and all of it is booked
    bool passivity = true;
    double damping_max_Ns_m = 3;    ///< most that the passivity controller injects; 1 kHz devices carry a few Ns/m

    void fields(StateBytes& state) noexcept { state(dt_s, force_max_N, slew_N_s, speed_max_m_s, stale_s, hold_s, passivity, damping_max_Ns_m); }
};

constexpr double surplus_fades_s = 5;

struct SafetyCounters {
    long long bad_input = 0;   ///< not finite, farther than a kilometre, or the device reported an error
    long long jump = 0;        ///< master moved faster than speed_max, over dt at least
    long long stale = 0;       ///< position too old
    long long late = 0;        ///< ticks so late that the device had let go of the force: it begins again at zero
    long long clamped = 0;     ///< ticks at force_max
    long long slewed = 0;      ///< rise of force cut to slew
    long long damped = 0;      ///< passivity controller at work
    long long capped = 0;      ///< force cut to what the bound on energy leaves (4)
    double force_max_N = 0;    ///< largest force that went out
    double energy_given_J = 0; ///< to the hand since the start, over all measured motion; negative: the hand gave

    void fields(StateBytes& state) noexcept { state(bad_input, jump, stale, late, clamped, slewed, damped, capped, force_max_N, energy_given_J); }
};

/// The forces that a device has held, from now back to some time ago. The newest is kept by itself, older ones in cells of a length that is given, each its impulse. Fixed size, no allocation.
class HeldForces {
   public:
    /// Held until now, for so long. cell_s: what is shorter shares a cell.
    void add(const Eigen::Vector3d& force_N, double seconds, double cell_s) noexcept;

    /// Mean over the time from so long ago to so long ago [N], from_s > to_s >= 0. Before what is kept there was none.
    Eigen::Vector3d mean_N(double from_s, double to_s) const noexcept;

    static constexpr int most_cells = 128;

    void fields(StateBytes& state) noexcept { state(newest_, cell_, first_); }

   private:
    struct Cell {
        double seconds = 0;
        Eigen::Vector3d impulse_Ns = Eigen::Vector3d::Zero();
        void fields(StateBytes& state) noexcept { state(seconds, impulse_Ns); }
    };
    Cell newest_, cell_[most_cells];
    int first_ = 0;  ///< the newest of them, the next one is older
};

/// The last stage of a tick, at the device's port. With F_n the force that goes out in tick n and dt the period:
///
///   1. A fault makes the force zero at once, and so does whoever stops it. A tick that comes later than half of
///      hold_s finds that the device has let go: F_{n-1} counts as zero from there on.
///   2. |F_n - k F_{n-1}| <= slew dt for some k in [0, 1]: force rises and turns by no more than slew dt, and falls at once. A force that fell slowly behind a hand that it
///      drives out would give energy that the tissue does not have.
///   3. |F_n| <= force_max.
///   4. E_n <= r_n B where `passivity` is on; see below.
///   5. The same with the time since tick n - 1 where that is less than dt.
///   6. Where the observer E_n shows a surplus, the force is damped to take it back: the time-domain passivity observer
///      and controller of Hannaford and Ryu (IEEE Trans. Robotics and Automation 18(1), 2002).
///   7. The wanted force.
///
/// This is their order: where two disagree, the one that stands higher is kept. The first four never disagree.
///
/// Energy. A force is held for one tick while the hand moves by dx, so the port gives exactly F dx. A device whose positions come less often than ticks
/// (DeviceSample::age_s tells), or are old when they are used, has its dx judged by the time between the two measurements, and F is the mean of what was held between them, as if the hand had
/// moved evenly. What has not been measured yet is in no book: of a device whose positions are old all that is given since the last of them. E_n is the sum of
/// that, credit of ended contacts left out; a surplus fades with the time constant surplus_fades_s, so that the tissue is stiff again
/// some seconds after a disturbance. A tick that finds its force let go books the worst instead. The motion of a
/// fault, which nobody measured, is not counted. With
///     W(F) = speed_max F dt,     B = W(force_max)
/// where W is what the fastest hand gets out of a force before the next tick, ticks on time,
///     E_n + r_n W(|F_n|) <= r_n B     at every tick, so E_n <= r_n B.
/// r_n >= 1 is the longest time between two ticks, or since the position in use was measured, in periods, since E + W was last within B: 1 while ticks are on time and bring
/// positions of their own (a tick that comes early counts as a whole one), and never more than hold_s / dt, of a device whose positions come less often (hold_s + stale_s) / dt. By default B = 0.0066 J and
/// r B <= 0.066 J; of C and Python, whose hosts may tick at 50 Hz (hold_s 0.05), 0.33 J after a stall, and on time the same B. What fades may be given anew: at most r B / surplus_fades_s, 1.3 mW of ticks on time.
/// This bound is for every device and hand whose positions are as old as they say. That a hand comes to rest on the tissue is not its work, and the controller has none to do then: see
/// contact_damping_s (haptic/dynamics.h) and DeviceImpedance.
/// Construction: when tick n + 1 comes after r dt at most, the hand has moved by speed_max r dt at most, or it is a
/// fault: E grows by r W(|F_n|) at most (of several ticks between two positions by their mean force times that, which is no more where force has come down in between). Then |F_{n+1}| is at
/// most the C with r W(C) = r B - E_{n+1}, which is the inequality.
class Safety {
   public:
    explicit Safety(const SafetyOptions& options) : o_(options), elapsed_s_(options.dt_s) {}

    /// Looks at a new sample before anything uses it, and books the energy of the tick behind. False: a fault, counted
    /// once by its kind; stop() must follow. elapsed_s: since the last call (ticks that were missed make it longer).
    bool admit(const DeviceSample& sample, double elapsed_s) noexcept;

    /// The force that may go out instead of the wanted one [N]. Not finite counts as nothing wanted. damp: with the controller of 6.
    Eigen::Vector3d limit(const Eigen::Vector3d& wanted_N, bool damp = true) noexcept;

    /// Zero now, whatever slew says.
    Eigen::Vector3d stop() noexcept;

    /// Contact has ended: what the hand gave before does not entitle the next contact to give it back.
    void forget_credit() noexcept {
        if (observed_J_ < 0) observed_J_ = 0;
    }

    /// The next sample begins the hand's way anew: what it went since the last one is no motion of a tick.
    void begin_way() noexcept { jumped_ = true; }
    bool has_motion() const { return has_motion_; }  ///< the last sample admitted and the one before it are one way of the hand
    double between_s() const { return between_s_; }  ///< these two were measured so far apart; 0: they are one position, that was read twice

    /// The device of another session: its limits, its force, its energy, its counts. dt is this one's.
    void go_on_from(const Safety& other) noexcept;
    const SafetyOptions& options() const { return o_; }

    /// Other limits from now on; the force that is held, and the energy that was given, are then within them.
    void become(const SafetyOptions& options) noexcept;

    void fields(StateBytes& state) noexcept {
        state(o_, counters_, force_N_, held_, position_m_, motion_m_, has_position_, has_motion_, jumped_, unknown_way_, elapsed_s_, since_good_s_, between_s_, allowed_s_, observed_J_, lateness_);
    }
    const SafetyCounters& counters() const { return counters_; }
    const Eigen::Vector3d& force_N() const { return force_N_; }
    double observed_J() const { return observed_J_; }                       ///< E
    double bound_J() const { return worst_release_J(o_.force_max_N); }      ///< B, ticks on time
    double lateness() const { return lateness_; }                           ///< r

   private:
    double worst_release_J(double force_N) const noexcept;   ///< W
    double releasable_N(double energy_J) const noexcept;     ///< its inverse
    void let_go(double elapsed_s) noexcept;
    bool follow(const Eigen::Vector3d& position_m, double age_s) noexcept;

    SafetyOptions o_;
    SafetyCounters counters_;
    Eigen::Vector3d force_N_ = Eigen::Vector3d::Zero();     ///< that went out last, and is still there
    HeldForces held_;                                       ///< up to now
    Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero();  ///< last good one
    Eigen::Vector3d motion_m_ = Eigen::Vector3d::Zero();    ///< in one period, as the hand moved in the tick behind
    bool has_position_ = false, has_motion_ = false, jumped_ = false;
    bool unknown_way_ = false;                              ///< a fault since the last good position: nobody measured how the hand came to the next one
    double elapsed_s_;                                      ///< of the tick behind
    double since_good_s_ = 0;                               ///< since the last good position was measured
    double between_s_ = 0;
    double allowed_s_ = 0;                                  ///< for how long the fastest hand may have moved: the time since the last position and what it left unused, dt at most of both
    double observed_J_ = 0;
    double lateness_ = 1;
};

}  // namespace tissue
