#include "lesson.h"

#include <iostream>

#include "error.h"

namespace tissue::serve {

Lesson::Lesson(const std::string& model_file, const std::string& hidden_file) : hidden_(read_model(hidden_file)), adaptation_(live_adaptation(model_file)) {
    if (hidden_.mesh.dimension() != adaptation_->base().mesh.dimension())
        throw MismatchError(hidden_file + ": the hidden tissue is of another dimension than " + model_file);
    hear(nullptr);
}

void Lesson::listen(Learner& learner) {
    learner.on_line([](const Learner::Line& line, const Adaptation&, void* with) { static_cast<Lesson*>(with)->hear(&line); }, this,
                    [](const char* why, void* with) { static_cast<Lesson*>(with)->end(why); });
}

/// Prints why learning has ended, and stores it for the pages.
void Lesson::end(const char* why) noexcept {
    std::cerr << "tissuectl serve: learning has ended, the session goes on without it: " << why << '\n';
    try {
        const std::lock_guard<std::mutex> lock(mutex_);
        News news;
        if (news_) news = std::move(*news_);  // the result of the last measurement, if no one has taken it
        news.ended = why;
        news_ = std::move(news);
    } catch (...) {  // out of memory: the message is printed already
    }
}

void Lesson::hear(const Learner::Line* line) {
    News news;
    if (line) {
        news.poke = line->poke;
        news.status = line->answer.status;
        news.why = line->answer.why;
        news.warning = line->answer.warning;
    }
    news.field = learned_field(*adaptation_);
    // in space the ranking takes longer than a user waits
    if (const SpringMesh& mesh = adaptation_->base().mesh; !mesh.is_solid()) {
        const std::vector<Push> pushes = pushes_over(adaptation_->surface(), mesh, usual_depth_m, adaptation_->surface().spacing_m());
        const std::vector<MeasurementGain> worth = rank_measurements(*adaptation_, pushes, pushes);
        if (!worth.empty()) news.next = pushes[worth.front().push];
    }
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        news_ = std::move(news);
    }
    if (line && tell_) tell_(*line);
}

std::optional<Lesson::News> Lesson::news() {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::optional<News> taken;
    taken.swap(news_);
    return taken;
}

}  // namespace tissue::serve
