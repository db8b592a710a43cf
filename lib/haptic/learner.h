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

/// What a model.h5 knows, to learn on while it plays: contacts are at least 1 mm unsure, for tissue swings as it is touched and the model's contact is
/// not quite where the hand's is; unknowns stay below live_bound, or below what the file has learned already. Both are of the session, whatever the
/// file has learned with, and are written into none (Adaptation::in_session). Throws as read_adaptation.
std::unique_ptr<Adaptation> live_adaptation(const std::string& file);
constexpr double live_bound = 1.5;            ///< of log stiffness: 4.5 times as stiff
constexpr double live_place_error_m = 1e-3;

/// A session's options for it: steps that bear what it may become, and no heuristic mesh, which does not learn and would fold under a stiffer tissue's force.
HapticOptions live_options(HapticOptions options, const Adaptation& adaptation);

struct LearnerOptions {
    double hold_s = 0.8;     ///< a hand that was still while the tissue went through so much time gives a reading, the mean of the second half: a swing of soft tissue
    double still_m = 2e-4;   ///< and still means within this
    double step = 0.002;     ///< every stiffness goes a tick at the most by this part of itself towards what was learned
    double patience_s = 10;  ///< at the end, for readings that are not learned yet: in space each takes a second or more, and up to 64 may wait
};

/// A law that learns while it plays, from a hand with a force sensor (DeviceSample::measured_N): whenever the hand holds still in the tissue
/// what it feels becomes a poke, a thread of its own learns from it (adapt/adaptation.h), and the tick's law goes there step by step, so that
/// in no tick force changes by more than `step` of it. Neither waits for the other; where ticks have no clock (TickBooks::clock) a reading is learned before the next tick,
/// so that what is learned does not depend on how fast the machine is. Of a law that relaxes the reading is taken as the
/// adaptation wants it, once all has relaxed or at once: times the law's static force of that kind over what it has in this tick. That
/// holds of a hand that holds still while the law is one and the same, and of the law that is still the one that learns: another reading is dropped.
///
/// What goes to the hand is bounded by Safety's slew and its own book whatever becomes of the law. HapticOptions::stiffest says how stiff
/// it may become; unknowns are kept below its logarithm.
///
/// Where learning fails (memory runs out, whoever hears its lines throws) it ends and the session goes on: the tick plays the last law that was
/// learned whole, the adaptation is that law, later readings are dropped, and failure() says why. A force that goes to zero because a disk is full
/// would be the greater surprise, and no tick depends on the learner.
class Learner final : public TickHook {
   public:
    /// model: of the one simulation that plays under it; it and the adaptation outlive this. Throws MismatchError where adaptation is
    /// of another mesh or may become stiffer than the model's steps bear.
    Learner(const HapticModel& model, Adaptation& adaptation, const LearnerOptions& options = {});
    ~Learner() override;

    bool before(Simulation& simulation) override;
    void after(const Simulation& simulation, const TickBooks& books) override;

    /// What became of a poke that the hand gave.
    struct Line {
        double time_s;       ///< of the session
        Poke poke;
        PokeAnswer answer;
    };
    /// Called in the learner's thread, one at a time, after each; failed: once, where learning has ended, with what failed; must not throw. Set before the session.
    void on_line(void (*tell)(const Line&, const Adaptation&, void*), void* with, void (*failed)(const char*, void*) = nullptr) {
        tell_ = tell, with_ = with, failed_ = failed;
    }

    /// Waits until all that was read is learned, or until the patience is at its end and the rest is dropped; ends the thread. Then the adaptation is
    /// the caller's again.
    void stop();

    /// Why learning has ended before its time; "" where it has not. After stop().
    const char* failure() const { return failure_.data(); }
    long long readings() const { return readings_.load(); }
    long long dropped() const { return dropped_.load(); }      ///< readings that came faster than they were learned, or too late to be, or of a law that relaxes and has changed since
    bool arrived() const { return arrived_; }                  ///< whether the tick's law is all that has been published

   private:
    struct Reading {
        double time_s = 0;
        Point contact_m, push_m, measured_N, model_N;
        int learned = 0;           ///< readings that the law has learned under which it was taken
    };
    struct Goal {
        LawStiffness stiffness;
        int learned = 0;           ///< readings that are in it
    };
    void publish();
    void begin_hold();
    void learn() noexcept;
    void try_to_learn_from(const Reading& reading) noexcept;
    void learn_from(const Reading& reading);

    const HapticModel& model_;
    Adaptation& adaptation_;
    LearnerOptions options_;
    // the tick's
    LawStiffness now_;
    bool arrived_ = true;
    int restores_ = 0;  ///< of the session, that it has seen: the law may be an older one
    bool relaxes_ = false, moves_ = false;     ///< the law: over time; in this tick, by what was learned
    int facet_ = -1;
    Eigen::Vector3d weight_ = Eigen::Vector3d::Zero();
    Point held_m_;
    Point sum_measured_N_, sum_model_N_, sum_push_m_;
    double held_s_ = 0, summed_s_ = 0;  ///< of the tissue's time, which counts where ticks are missed, too
    long long pushed_ = 0;
    bool taken_ = false;
    // between the two
    SpscRing<Reading> readings_to_learn_;
    Latest<Goal> learned_;
    std::atomic<long long> readings_{0}, dropped_{0}, done_{0};  ///< done: of those pushed
    std::atomic<bool> stop_{false};
    // the thread's
    void (*tell_)(const Line&, const Adaptation&, void*) = nullptr;
    void* with_ = nullptr;
    void (*failed_)(const char*, void*) = nullptr;
    bool ended_ = false;
    std::array<char, 512> failure_{};
    std::thread thread_;
};

}  // namespace tissue
