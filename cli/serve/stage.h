#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "haptic/target_tissue.h"
#include "haptic/pointer_device.h"
#include "haptic/realtime_loop.h"
#include "haptic/recorder.h"
#include "haptic/state_channel.h"
#include "mesh/msh_file.h"
#include "scene.h"

namespace tissue::serve {

struct StageOptions {
    HapticOptions haptic;
    bool realtime = true;
    std::string surface = {};  ///< file of a surface that the first model carries and the page draws; empty: none
    double unit_m = 1;         ///< unit of its numbers [m]
    /// model.h5 of the target tissue that the pointer also touches, and that the one model learns from; empty: none
    std::string hidden = {};
};

/// Counts of a session over all its models. They never decrease.
struct StageCounts {
    long long ticks = 0, misses = 0, misses_program = 0, clamped = 0, slewed = 0, damped = 0;
    long long capped = 0, late = 0, not_finite = 0, jumps = 0, stale = 0, folded = 0, unstable = 0;
    double lost_s = 0;
    long long faults() const { return not_finite + jumps + stale; }
};

/// Several models, one of which ticks in its own thread, with one pointer per tool. All functions are called in the
/// server's thread; only turn_to() and stop() wait for the tick.
class Stage {
   public:
    /// files: model.h5 files; with a hidden tissue only one, of an energy model. Throws FileError, MismatchError.
    Stage(const std::vector<std::string>& files, const StageOptions& options);
    ~Stage();
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

    void start(Recorder* recorder);
    /// Changes to another model, which starts at rest. Throws FileError, MismatchError where it cannot be made, and goes
    /// on as before.
    void turn_to(int model);
    void reset();                       ///< puts every mesh, and the hidden tissue, to rest
    void stop();                        ///< after this there is no force
    bool failed() const { return failed_.load(); }
    /// call after stop(); "" where learning did not fail
    const char* learning_failure() const { return learner_ ? learner_->failure() : ""; }

    int index() const { return index_; }
    /// Models by study; those that know several discs also with each other tool.
    const std::vector<std::string>& names() const { return names_; }
    /// about files beside the models that are not used
    const std::vector<std::string>& warnings() const { return warnings_; }
    Scene& scene() { return *served_[static_cast<std::size_t>(index_)].scene; }
    const Scene& scene() const { return *served_[static_cast<std::size_t>(index_)].scene; }
    const HapticModel& model() const { return *served_[static_cast<std::size_t>(index_)].model; }
    StateChannel& channel() { return *channel_; }
    const StateChannel& channel() const { return *channel_; }
    int tools() const { return static_cast<int>(pointers_.size()); }
    PointerDevice& pointer(int tool = 0) { return *pointers_[static_cast<std::size_t>(tool)]; }
    std::vector<Device*> pointers() const { return {pointers_.begin(), pointers_.end()}; }
    /// devices that the tick reads: the pointers, or the TargetTissue that wraps one
    std::vector<Device*> devices() const;

    /// nullptr where no model learns.
    Lesson* lesson() { return lesson_.get(); }

    /// Counts of the present model and those before it, up to the last state that was fetched.
    StageCounts counts() const;

    // call after stop()
    const Simulation& simulation() const { return *simulation_; }
    const LoopReport& report() const { return report_; }

   private:
    /// One entry of names(): a model with a tool. Those of other tools are made when they are first asked for.
    struct Served {
        std::string file;
        ToolChoices tool;
        std::unique_ptr<HapticModel> model = nullptr;
        std::unique_ptr<Scene> scene = nullptr;
    };
    void make(Served& served, const TissueModel& tissue);
    void make(Served& served, const TissueModel& tissue, const TissueModel& of_tool, const HapticOptions& haptic, const std::vector<NodeField>& fe_displacement_m, std::optional<LearnedField> learned) const;
    void carry(Served& served) const;
    void serve_other_tools(const std::string& file, const TissueModel& tissue);
    void run();
    void take_pointers();

    StageOptions options_;
    bool some_sets_ = false;   ///< whether a model has spring sets
    std::optional<MshFile> carried_;  ///< of options_.surface
    std::vector<std::string> names_, warnings_;
    std::vector<Served> served_;
    int index_ = 0;
    Recorder* recorder_ = nullptr;
    std::unique_ptr<Lesson> lesson_;
    std::vector<std::unique_ptr<Device>> devices_;  ///< the pointers, or the TargetTissue that wraps one
    std::vector<PointerDevice*> pointers_;          ///< one per tool
    TargetTissue* hidden_ = nullptr;    ///< the hidden tissue, where there is a lesson
    std::unique_ptr<StateChannel> channel_;
    std::unique_ptr<Simulation> simulation_;
    std::unique_ptr<Learner> learner_;
    std::thread thread_;
    std::atomic<bool> stop_{false}, failed_{false};
    LoopReport report_;                 ///< of the last loop that has ended
    StageCounts before_;                ///< of the loops that have ended
};

}  // namespace tissue::serve
