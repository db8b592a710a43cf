#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "adapt/adapted_model.h"
#include "adapt/next_poke.h"
#include "haptic/learner.h"
#include "springs/tissue_model.h"

namespace tissue::serve {

/// A stage's law that learns from a tissue which nobody sees, and the pointer's tool touches: what it knows, and the news of it.
class Lesson {
   public:
    /// Files of a law, and of the tissue that is touched. Throws FileError, MismatchError.
    Lesson(const std::string& model_file, const std::string& hidden_file);

    const TissueModel& hidden() const { return hidden_; }
    Adaptation& adaptation() { return *adaptation_; }

    /// What became of a reading.
    struct News {
        std::optional<LearnedField> field;  ///< as it is after it; nothing where other unknowns than a field learn
        std::optional<Poke> poke;           ///< nothing before the first
        PokeStatus status = PokeStatus::refused;
        std::string why, warning;
        std::string ended;                  ///< why learning has ended; else empty
        std::optional<Push> next;           ///< what would tell most now; in the plane
    };

    /// Takes the learner's lines; before the ticks begin.
    void listen(Learner& learner);

    /// Called in the learner's thread with every line, after what the news is made of it. Set before the session.
    void also_tell(std::function<void(const Learner::Line&)> tell) { tell_ = std::move(tell); }

    /// The newest that was not asked for yet. Another thread's than the learner's.
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
