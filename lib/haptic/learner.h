#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "adapt/adapted_model.h"
#include "haptic/latest.h"
#include "haptic/spsc_ring.h"
#include "haptic/tick_hook.h"

namespace tissue {

/// Reads the adaptation in a model.h5, to continue it during a session. Two limits hold for the session only, and are
/// not written to files (Adaptation::in_session). First, the error of a contact's place is at least live_place_error_m:
/// the tissue oscillates while it is touched, and the model's contact is not exactly where the hand's is. Second, the
/// unknowns stay below live_bound, or below the largest one in the file if that is larger. Throws as read_adaptation.
std::unique_ptr<Adaptation> live_adaptation(const std::string& file);
constexpr double live_bound = 1.5;            ///< of |log stiffness|: 4.5 times as stiff
constexpr double live_place_error_m = 1e-3;   ///< standard deviation along the surface

/// Options for a session with adaptation. `stiffest` is set to what the adaptation allows, so that the steps stay
/// stable. The heuristic mesh is off: it does not adapt, and would fold under the force of a stiffer tissue.
HapticOptions live_options(HapticOptions options, const Adaptation& adaptation);

struct LearnerOptions {
    /// Time of the tissue for which the hand must be still to give a measurement. The measurement is the mean over the
    /// second half, which is about one period of soft tissue.
    double hold_s = 0.8;
    double still_m = 2e-4;   ///< largest change of the tool displacement of a hand that counts as still
    double step = 0.002;     ///< largest relative change of each stiffness in a tick, towards the adapted one
    /// Longest time that stop() waits for measurements in the queue. In space each takes a second or more, and up to 64
    /// may wait.
    double patience_s = 10;
};

/// Adapts an energy model during a session, from the measurements of a force sensor in the tool
/// (DeviceSample::measured_N).
///
/// A measurement is taken whenever the hand keeps still in the tissue. A thread of the learner adapts the model to it
/// (adapt/adaptation.h). The energy model in the tick then follows in small steps, so that the force changes by at most
/// the part `step` in a tick. With a clock neither thread waits for the other. Without one (TickStatistics::clock is false)
/// the next tick waits for the adaptation, so that the result does not depend on the speed of the machine.
///
/// For a model that relaxes, the measured force is converted to the static force that the adaptation expects: long-term
/// or instantaneous (AdaptOptions::at_rest). It is multiplied by the model's static force of that kind over the model's
/// force in the session. This needs a model that does not change during the measurement, that has adapted to nothing
/// else since, and that has an equilibrium there; other measurements are dropped.
///
/// The slew and the energy bound of Safety limit the force on the hand, whatever the model becomes. The unknowns are
/// kept below log(HapticOptions::stiffest), for which the steps are stable.
///
/// When an adaptation fails (out of memory, or a callback throws), adaptation ends and the session goes on. The tick
/// keeps the last complete energy model, and the adaptation is reset to it. Later measurements are dropped, and
/// failure() gives the cause. No tick needs the learner, and the end of a session sets the force on the hand to zero: a
/// full disk is no reason for that.
class Learner final : public TickHook {
   public:
    /// model: of the simulation that calls this hook; no other simulation may call it. It and the adaptation must
    /// outlive the learner.
    /// Throws MismatchError where the model is no energy model, its tool is not a disc, the adaptation is of another
    /// mesh, or it may become stiffer than the model's steps allow.
    Learner(const HapticModel& model, Adaptation& adaptation, const LearnerOptions& options = {});
    ~Learner() override;

    bool before(Simulation& simulation) override;
    void after(const Simulation& simulation, const TickStatistics& books) override;

    /// A measurement in the session and its result.
    struct Line {
        double time_s;       ///< session time of the measurement
        ForceMeasurement poke;
        UpdateResult answer;
    };
    /// Sets callbacks, before the session. Both run in the learner's thread and get `with`. tell: called after each
    /// measurement that was not dropped. failed: called once with the cause when adaptation has failed; must not throw.
    void on_line(void (*tell)(const Line&, const Adaptation&, void*), void* with, void (*failed)(const char*, void*) = nullptr) {
        tell_ = tell, with_ = with, failed_ = failed;
    }

    /// Waits until the queue is empty and ends the thread. From patience_s on, measurements in the queue are dropped.
    /// After this call the caller may use the adaptation again.
    void stop();

    /// Cause of a failed adaptation, "" without a failure. To be called after stop().
    const char* failure() const { return failure_.data(); }
    long long readings() const { return readings_.load(); }    ///< number of measurements
    /// Number of measurements that were not used: the queue was full, patience_s was over, adaptation had failed, or a
    /// model that relaxes had changed since or had no equilibrium there.
    long long dropped() const { return dropped_.load(); }
    bool arrived() const { return arrived_; }                  ///< the tick's model equals the one published last

   private:
    struct Reading {
        double time_s = 0;
        Point contact_m, push_m, measured_N, model_N;
        int learned = 0;           ///< number of measurements in the model under which it was taken
    };
    struct Goal {
        EnergyModelStiffness stiffness;
        int learned = 0;           ///< number of measurements in it
    };
    void publish();
    void begin_hold();
    void learn() noexcept;
    void try_to_learn_from(const Reading& reading) noexcept;
    void learn_from(const Reading& reading);

    const HapticModel& model_;
    Adaptation& adaptation_;
    LearnerOptions options_;
    // used by the tick
    EnergyModelStiffness now_;
    bool arrived_ = true;
    int restores_ = 0;  ///< Simulation::restores() seen last; a restored session may have an older energy model
    bool relaxes_ = false, moves_ = false;     ///< the energy model has Maxwell branches; it changes in this tick
    int facet_ = -1;
    Eigen::Vector3d weight_ = Eigen::Vector3d::Zero();
    Point held_m_;
    Point sum_measured_N_, sum_model_N_, sum_push_m_;
    double held_s_ = 0, summed_s_ = 0;  ///< time of the tissue, which is right after missed ticks too
    long long pushed_ = 0;              ///< measurements put into the queue
    bool taken_ = false;                ///< this hold has given its measurement
    // shared by both threads
    SpscRing<Reading> readings_to_learn_;
    Latest<Goal> learned_;
    std::atomic<long long> readings_{0}, dropped_{0}, done_{0};  ///< done: taken from the queue and finished
    std::atomic<bool> stop_{false};
    // used by the learner's thread
    void (*tell_)(const Line&, const Adaptation&, void*) = nullptr;
    void* with_ = nullptr;
    void (*failed_)(const char*, void*) = nullptr;
    bool ended_ = false;
    std::array<char, 512> failure_{};
    std::thread thread_;
};

}  // namespace tissue
