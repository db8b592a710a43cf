#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "adapt/adapted_model.h"
#include "adapt/next_measurement.h"
#include "haptic/learner.h"
#include "springs/tissue_model.h"

namespace tissue::serve {

/// Adaptation of a stage's energy model to a hidden target tissue, which the pointer's tool also touches; and the
/// results for the pages.
class Lesson {
   public:
    /// Files of an energy model and of the target tissue. Throws FileError, MismatchError.
    Lesson(const std::string& model_file, const std::string& hidden_file);

    const TissueModel& hidden() const { return hidden_; }
    Adaptation& adaptation() { return *adaptation_; }

    /// Result of a measurement.
    struct News {
        std::optional<LearnedField> field;  ///< the field after it; nullopt where the unknowns are not a field
        std::optional<ForceMeasurement> poke;           ///< nullopt before the first measurement
        UpdateStatus status = UpdateStatus::refused;
        std::string why, warning;
        std::string ended;                  ///< why learning has ended; else empty
        std::optional<Push> next;           ///< the most informative next indentation; only in the plane
    };

    /// Receives the lines of the learner. Call before the ticks begin.
    void listen(Learner& learner);

    /// Sets a function that is called in the learner's thread with every line, after the news of it is stored. Set
    /// before the session.
    void also_tell(std::function<void(const Learner::Line&)> tell) { tell_ = std::move(tell); }

    /// Takes the newest result; nullopt if it was taken already. For another thread than the learner's.
    std::optional<News> news();

   private:
    void hear(const Learner::Line* line);
    void end(const char* why) noexcept;

    TissueModel hidden_;
    std::unique_ptr<Adaptation> adaptation_;
    std::function<void(const Learner::Line&)> tell_;
    std::mutex mutex_;
    std::optional<News> news_;
};

}  // namespace tissue::serve
