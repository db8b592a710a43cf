#pragma once

#include <Eigen/Core>

#include "haptic/device.h"
#include "haptic/state_bytes.h"

namespace tissue {

struct SafetyOptions {
    double dt_s = 1e-3;             ///< 1 kHz
    /// largest force: of a Touch and its predecessor PHANTOM Omni, at the nominal position
    double force_max_N = 3.3;
    /// largest rate at which the force rises: 5 N per tick of 1 ms. Where the tissue's force rises faster, the device's
    /// lags behind it: the hand then puts in less energy on the way in than it receives on the way out, within the
    /// bound on energy (Safety)
    double slew_N_s = 5000;
    double speed_max_m_s = 2;       ///< of the device; hands at work stay below about 1 m/s
    double stale_s = 0.05;          ///< age of the oldest position that is accepted
    /// how long the device holds a force without a new one; infinite: until the next force, and the energy of all that
    /// time counts
    double hold_s = force_held_s;
    bool passivity = true;          ///< passivity observer and controller, and the bound on energy
    double damping_max_Ns_m = 3;    ///< largest damping of the passivity controller; 1 kHz devices bear a few Ns/m

    void fields(StateBytes& state) noexcept { state(dt_s, force_max_N, slew_N_s, speed_max_m_s, stale_s, hold_s, passivity, damping_max_Ns_m); }
};

constexpr double surplus_fades_s = 5;  ///< time constant with which an energy surplus fades

struct SafetyCounters {
    long long bad_input = 0;   ///< position not finite, farther than a kilometre, or the device reported an error
    long long jump = 0;        ///< device moved faster than speed_max, judged over dt at least
    long long stale = 0;       ///< position too old
    long long late = 0;        ///< ticks so late that the device had released its force, which restarts at zero
    long long clamped = 0;     ///< ticks at force_max
    long long slewed = 0;      ///< ticks whose change of force was limited by slew
    long long damped = 0;      ///< ticks in which the passivity controller damped
    long long capped = 0;      ///< ticks whose force was limited by the bound on energy (rule 4 of Safety)
    double force_max_N = 0;    ///< largest force that went out
    /// energy given to the hand since the start, over all measured motion, with the worst case for late ticks;
    /// negative: the hand gave energy
    double energy_given_J = 0;

    void fields(StateBytes& state) noexcept { state(bad_input, jump, stale, late, clamped, slewed, damped, capped, force_max_N, energy_given_J); }
};

/// Forces that a device has held, from now back in time. The newest force is stored by itself, older ones as impulses
/// in cells of time. Fixed size, no allocation.
class HeldForces {
   public:
    /// Adds a force that was held for `seconds` until now. cell_s: forces share a cell up to this length.
    void add(const Eigen::Vector3d& force_N, double seconds, double cell_s) noexcept;

    /// Mean force in the time from from_s ago to to_s ago [N], from_s > to_s >= 0. Before the stored time the force was
    /// 0.
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
    int first_ = 0;  ///< number of the newest cell; the next one is older
};

/// The last stage of a tick, at the device's port: checks positions and limits forces. F_n is the force that goes out
/// in tick n, dt the period. The rules, in order of priority:
///
///   1. A fault sets the force to zero at once, and so does stop(). After a tick that comes later than half of hold_s
///      the device may have released its force: F_{n-1} counts as zero from then on.
///   2. |F_n - k F_{n-1}| <= slew dt for some k in [0, 1]: the force may fall to any part k of the last one at once; from
///      there it rises or turns by slew dt at most. A force that fell slowly while the hand moves out would do work
///      that the tissue does not.
///   3. |F_n| <= force_max.
///   4. E_n <= r_n B where `passivity` is on; see below.
///   5. Rule 2 with the time since tick n - 1 in place of dt, where that is shorter.
///   6. Where the observer E_n shows a surplus, the force is damped to remove it: the time-domain passivity observer
///      and controller of Hannaford and Ryu (IEEE Trans. Robotics and Automation 18(1), 2002).
///   7. The force is the wanted one.
///
/// Where two rules contradict each other, the earlier one holds. The first four never contradict each other.
///
/// Energy. A force is held for one tick while the hand moves by dx, so that the port gives exactly F dx. Positions may
/// come less often than ticks, or be old when they are used (DeviceSample::age_s). Then dx belongs to the time between
/// the two measurements, and F is the mean of the forces held in that time, as if the hand had moved evenly. Energy of
/// motion that is not measured yet is not counted: with old positions, all that was given since the last measurement.
/// E_n is the sum of these energies, without the credit of ended contacts (forget_credit()). A surplus fades with the
/// time constant surplus_fades_s, so that the tissue is stiff again some seconds after a disturbance. A late tick,
/// whose force counts as released, adds the worst case instead. Motion during a fault was not measured and is not
/// counted.
///
/// Bound. With
///     W(F) = speed_max F dt,     B = W(force_max),
/// W is the energy that the fastest hand takes from a force before the next tick, if ticks are on time. At every tick
///     E_n + r_n W(|F_n|) <= r_n B,     so E_n <= r_n B.
/// r_n >= 1 is a number of periods: the longest time between two ticks, or from the measurement of the position in use
/// to the next tick. Only the time since E + W was last within B counts. r_n is 1 while ticks are on time and each has
/// a new position; an early tick counts as a whole period. r_n is at most hold_s / dt, or (hold_s + stale_s) / dt for a
/// device whose positions come less often than ticks. By default B = 0.0066 J and r B <= 0.066 J. In C and Python,
/// whose hosts may tick at 50 Hz (hold_s 0.05), r B is 0.33 J after a stall, and B is the same. A surplus that has
/// faded may be given again: at most r B / surplus_fades_s, 1.3 mW for ticks on time.
///
/// The bound holds for every device and hand whose positions are as old as stated. It does not make a hand come to rest
/// on the tissue, and the controller does not act in that case: see contact_damping_s (haptic/dynamics.h) and
/// DeviceImpedance.
///
/// Proof. If tick n + 1 comes after r dt at most, the hand has moved by speed_max r dt at most, or the position is a
/// fault. So E grows by r W(|F_n|) at most. With several ticks between two positions it grows by r W of their mean
/// force, which also stays within r B where the force has fallen in between. Rule 4 limits |F_{n+1}| to the C of
///     r W(C) = r B - E_{n+1},
/// which is the inequality.
class Safety {
   public:
    explicit Safety(const SafetyOptions& options) : o_(options), elapsed_s_(options.dt_s) {}

    /// Checks a new sample before anything uses it, and counts the energy of the previous tick. Returns false for a
    /// fault, which is counted once, by its kind; stop() must follow. elapsed_s: time since the last call, which missed
    /// ticks make longer.
    bool admit(const DeviceSample& sample, double elapsed_s) noexcept;

    /// The force that may go out in place of the wanted one [N]. A wanted force that is not finite counts as zero.
    /// damp: whether the controller of rule 6 acts.
    Eigen::Vector3d limit(const Eigen::Vector3d& wanted_N, bool damp = true) noexcept;

    /// Sets the force to zero at once, without the limit of slew.
    Eigen::Vector3d stop() noexcept;

    /// A contact has ended: energy that the hand gave before is not available to the next contact.
    void forget_credit() noexcept {
        if (observed_J_ < 0) observed_J_ = 0;
    }

    /// The next sample starts a new motion of the hand: the displacement since the last sample is not that of one tick.
    void begin_way() noexcept { jumped_ = true; }
    bool has_motion() const { return has_motion_; }  ///< the last two admitted samples belong to one motion of the hand
    /// time between their measurements; 0: the same position was read twice
    double between_s() const { return between_s_; }

    /// Takes over the device of another session: its limits, force, energy and counts. dt stays.
    void go_on_from(const Safety& other) noexcept;
    const SafetyOptions& options() const { return o_; }

    /// Sets other limits. The force that is held, and E, are reduced to what they allow.
    void become(const SafetyOptions& options) noexcept;

    void fields(StateBytes& state) noexcept {
        state(o_, counters_, force_N_, held_, position_m_, motion_m_, has_position_, has_motion_, jumped_, unknown_way_, elapsed_s_, since_good_s_, between_s_, allowed_s_, observed_J_, lateness_);
    }
    const SafetyCounters& counters() const { return counters_; }
    const Eigen::Vector3d& force_N() const { return force_N_; }
    double observed_J() const { return observed_J_; }                       ///< E
    double bound_J() const { return worst_release_J(o_.force_max_N); }      ///< B
    double lateness() const { return lateness_; }                           ///< r

   private:
    double worst_release_J(double force_N) const noexcept;   ///< W
    double releasable_N(double energy_J) const noexcept;     ///< inverse of W
    void let_go(double elapsed_s) noexcept;
    bool follow(const Eigen::Vector3d& position_m, double age_s) noexcept;

    SafetyOptions o_;
    SafetyCounters counters_;
    Eigen::Vector3d force_N_ = Eigen::Vector3d::Zero();     ///< force that went out last, still on the device
    HeldForces held_;                                       ///< forces held until now
    /// last position that was finite and not stale, jumps included
    Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d motion_m_ = Eigen::Vector3d::Zero();    ///< motion in one period, at the hand's last velocity
    bool has_position_ = false, has_motion_ = false, jumped_ = false;
    /// the motion to the next position is not counted: a fault came before it, or limits were lowered
    bool unknown_way_ = false;
    double elapsed_s_;                                      ///< duration of the previous tick
    double since_good_s_ = 0;                               ///< time since position_m_ was measured
    double between_s_ = 0;
    /// time at speed_max that the last motion left unused. The next motion may take this and the time between the two
    /// positions, together at most the larger of dt and that time
    double allowed_s_ = 0;
    double observed_J_ = 0;
    double lateness_ = 1;
};

}  // namespace tissue
