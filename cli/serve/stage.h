#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "haptic/hidden_tissue.h"
#include "haptic/pointer_device.h"
#include "haptic/realtime_loop.h"
#include "haptic/recorder.h"
#include "haptic/state_channel.h"
#include "scene.h"

namespace tissue::serve {

struct StageOptions {
    HapticOptions haptic;
    bool realtime = true;
    std::string surface = {};  ///< a surface's file that the first model carries and the page draws; often none
    double unit_m = 1;         ///< [m] of its numbers
    std::string hidden = {};   ///< model.h5 of a tissue that the pointer touches in truth, and the one model learns from; often none
};

/// The counts of a session over all its models, as they only grow.
struct StageCounts {
    long long ticks = 0, misses = 0, misses_program = 0, clamped = 0, slewed = 0, damped = 0;
    long long capped = 0, late = 0, not_finite = 0, jumps = 0, stale = 0, folded = 0, unstable = 0;
    double lost_s = 0;
    long long faults() const { return not_finite + jumps + stale; }
};

/// Several models, one of which ticks in a thread of its own, pressed by a pointer for each tool. Every function is the server's
/// thread's; none but start(), turn_to() and stop() waits for the tick.
class Stage {
   public:
    /// Throws FileError, MismatchError.
    /// With a hidden tissue there may be one file, of a law.
    Stage(const std::vector<std::string>& files, const StageOptions& options);
    ~Stage();
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

    void start(Recorder* recorder);
    void turn_to(int model);            ///< another model, from rest
    void reset();                       ///< every mesh to rest, and the hidden tissue
    void stop();                        ///< no force any more when this returns
    bool failed() const { return failed_.load(); }
    const char* learning_failure() const { return learner_ ? learner_->failure() : ""; }  ///< after stop(); "" where there is none

    int index() const { return index_; }
    const std::vector<std::string>& names() const { return names_; }
    const std::vector<std::string>& warnings() const { return warnings_; }  ///< of files beside the models that are not used
    Scene& scene() { return *served_[static_cast<std::size_t>(index_)].scene; }
    const Scene& scene() const { return *served_[static_cast<std::size_t>(index_)].scene; }
    const HapticModel& model() const { return *served_[static_cast<std::size_t>(index_)].model; }
    StateChannel& channel() { return *channel_; }
    const StateChannel& channel() const { return *channel_; }
    int tools() const { return static_cast<int>(pointers_.size()); }
    PointerDevice& pointer(int tool = 0) { return *pointers_[static_cast<std::size_t>(tool)]; }
    std::vector<Device*> pointers() const { return {pointers_.begin(), pointers_.end()}; }
    std::vector<Device*> devices() const;  ///< what the tick reads: the pointers, or the hidden tissue that one presses

    /// Nothing where no model learns.
    Lesson* lesson() { return lesson_.get(); }

    /// What the running model and those before it have counted, up to the last state that was fetched.
    StageCounts counts() const;

    // after stop()
    const Simulation& simulation() const { return *simulation_; }
    const LoopReport& report() const { return report_; }

   private:
    struct Served {
        std::unique_ptr<HapticModel> model;
        std::unique_ptr<Scene> scene;
    };
    void serve(const std::string& file, const TissueModel& tissue, const HapticOptions& haptic, const std::vector<NodeField>& fe_displacement_m,
               std::optional<LearnedField> learned);
    void run();
    void take_pointers();

    StageOptions options_;
    std::vector<std::string> names_, warnings_;
    std::vector<Served> served_;
    int index_ = 0;
    Recorder* recorder_ = nullptr;
    std::unique_ptr<Lesson> lesson_;
    std::vector<std::unique_ptr<Device>> devices_;  ///< the pointers, or what has one
    std::vector<PointerDevice*> pointers_;          ///< of each tool
    HiddenTissue* hidden_ = nullptr;    ///< what has it, where there is a lesson
    std::unique_ptr<StateChannel> channel_;
    std::unique_ptr<Simulation> simulation_;
    std::unique_ptr<Learner> learner_;
    std::thread thread_;
    std::atomic<bool> stop_{false}, failed_{false};
    LoopReport report_;                 ///< of the last loop that has ended
    StageCounts before_;                ///< of loops that have ended
};

}  // namespace tissue::serve
