#include "stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "error.h"
#include "hand.h"
#include "springs/law_at_radius.h"
#include "surface_file/surface_file.h"
#include "surface_file/vtk_file.h"

namespace tissue::serve {
namespace {

void add(StageCounts& sum, const SafetyCounters& s) {
    sum.clamped += s.clamped;
    sum.slewed += s.slewed;
    sum.damped += s.damped;
    sum.capped += s.capped;
    sum.late += s.late;
    sum.not_finite += s.bad_input;
    sum.jumps += s.jump;
    sum.stale += s.stale;
}

void add(StageCounts& sum, const TickBooks& books, const HapticCounters& h) {
    sum.ticks += books.ticks;
    sum.misses += books.misses;
    sum.misses_program += books.misses_program;
    sum.lost_s += h.lost_s;
    sum.folded += h.folded;
    sum.unstable += h.unstable;
}

/// "results/paper/model.h5" -> paper; two alike get a number.
std::string name_for(const std::string& study, const std::vector<std::string>& taken) {
    std::string name = study;
    for (int k = 2; std::find(taken.begin(), taken.end(), name) != taken.end(); ++k) name = fmt::format("{} ({})", study, k);
    return name;
}

/// For an energy model that is served beside spring sets: options that are theirs apply to them alone.
HapticOptions without_sets(HapticOptions options, const TissueModel& tissue) {
    options.sets.clear();
    options.select_by = SelectBy::displacement;
    options.innovation.reset();
    if (tissue.mesh.is_solid() || !options.heuristic_mesh) options.coupling_ratio.reset();  // in the plane the heuristic mesh has one
    return options;
}

}  // namespace

Stage::Stage(const std::vector<std::string>& files, const StageOptions& options) : options_(options) {
    if (!options_.hidden.empty()) {
        if (files.size() != 1) throw MismatchError("one model learns, not one of several");
        if (options_.haptic.tools > 1) throw MismatchError("--tools: a model learns from one tool");
        if (!options_.haptic.tool.is_default()) throw MismatchError("--tool: a model that learns while it plays has its own disc");
        lesson_ = std::make_unique<Lesson>(files.front(), options_.hidden);
        // finite elements knew the tissue it was trained on, not this one
        TissueModel tissue = lesson_->adaptation().base();
        tissue.contact_force_N.resize(0, tissue.contact_force_N.cols());
        serve(files.front(), tissue, live_options(options_.haptic, lesson_->adaptation()), {}, learned_field(lesson_->adaptation()));
    } else {
        std::vector<TissueModel> tissues;
        for (const std::string& file : files) try {
                tissues.push_back(with_tool(read_model(file), options_.haptic.tool));
            } catch (const MismatchError& e) {
                throw MismatchError(file + ": " + e.what());
            }
        const bool some_sets = std::any_of(tissues.begin(), tissues.end(), [](const TissueModel& t) { return !t.energy_law; });
        for (std::size_t k = 0; k < files.size(); ++k) {
            const std::string& file = files[k];
            const TissueModel& tissue = tissues[k];
            const std::optional<LearnedField> learned = learned_field(file);
            const FeCases fe = learned ? FeCases() : read_fe_cases(file, tissue);  // of another tissue than it has become
            if (!fe.warning.empty()) warnings_.push_back(fe.warning);
            KnownErrors known = learned ? KnownErrors() : read_known_errors(file, tissue);
            if (!known.warning.empty()) warnings_.push_back(known.warning);
            serve(file, tissue, some_sets && tissue.energy_law ? without_sets(options_.haptic, tissue) : options_.haptic, fe.displacement_m, learned);
            served_.back().scene->know(std::move(known.all));
        }
    }
    if (!options_.surface.empty()) {
        refuse_vtk(options_.surface);
        const MshFile surface = read_surface_or_msh(options_.surface, options_.surface);
        try {
            scene().carry(carried_surface(scene().mesh(), surface, options_.unit_m));
        } catch (const MismatchError& e) {
            throw MismatchError(files.front() + ": " + e.what());
        }
    }
    take_pointers();
    simulation_ = std::make_unique<Simulation>(model());
    channel_ = std::make_unique<StateChannel>(model());
    if (!lesson_) return;
    learner_ = std::make_unique<Learner>(*served_.front().model, lesson_->adaptation());
    lesson_->listen(*learner_);
}

void Stage::serve(const std::string& file, const TissueModel& tissue, const HapticOptions& haptic, const std::vector<NodeField>& fe_displacement_m,
                  std::optional<LearnedField> learned) {
    Served served;
    try {
        served.model = std::make_unique<HapticModel>(tissue, haptic);
        served.scene = std::make_unique<Scene>(tissue, *served.model, fe_displacement_m, std::move(learned));
    } catch (const MismatchError& e) {
        throw MismatchError(file + ": " + e.what());
    }
    names_.push_back(name_for(tissue.study, names_));
    served_.push_back(std::move(served));
}

/// Pointers in the model's own space, above its middle, and side by side.
void Stage::take_pointers() {
    devices_.clear();
    pointers_.clear();
    for (int tool = 0; tool < model().options.tools; ++tool) {
        const Hand hand(scene(), tool);
        auto pointer = std::make_unique<PointerDevice>(hand.at(), model().options.map, options_.haptic.safety.speed_max_m_s);
        pointers_.push_back(pointer.get());
        devices_.push_back(std::move(pointer));
    }
    if (!lesson_) return;
    HapticOptions hand = options_.haptic;
    hand.map = model().options.map;
    try {
        auto hidden = std::make_unique<HiddenTissue>(std::move(devices_.front()), lesson_->hidden(), hand);
        hidden_ = hidden.get();
        devices_.front() = std::move(hidden);
    } catch (const MismatchError& e) {
        throw MismatchError(options_.hidden + ": " + e.what());
    }
}

std::vector<Device*> Stage::devices() const {
    std::vector<Device*> all;
    for (const auto& device : devices_) all.push_back(device.get());
    return all;
}

void Stage::reset() {
    channel_->reset();
    if (hidden_) hidden_->reset();
}

Stage::~Stage() {
    stop();
}

void Stage::start(Recorder* recorder) {
    recorder_ = recorder;
    stop_.store(false);
    thread_ = std::thread([this] { run(); });
}

void Stage::run() {
    try {
        LoopOptions loop;
        loop.seconds = 0;
        loop.stop = &stop_;
        loop.realtime = options_.realtime;
        loop.hooks.push_back(channel_.get());
        if (recorder_) loop.hooks.push_back(recorder_);
        if (learner_) loop.hooks.push_back(learner_.get());
        report_ = run_loop(*simulation_, devices(), loop);
    } catch (const std::exception& e) {
        std::cerr << "tissuectl serve: the tick has ended: " << e.what() << '\n';
        failed_.store(true);
    }
}

void Stage::stop() {
    if (!thread_.joinable()) return;
    stop_.store(true);
    thread_.join();
    TickBooks books;
    books.ticks = report_.ticks;
    books.misses = report_.misses;
    books.misses_program = report_.misses_program;
    if (learner_) learner_->stop();
    add(before_, books, simulation_->counters());
    for (int tool = 0; tool < tools(); ++tool) add(before_, simulation_->safety(tool).counters());
}

void Stage::turn_to(int model_index) {
    stop();
    const int dimension = model().dimension();
    index_ = model_index;
    if (model().dimension() != dimension) take_pointers();
    simulation_ = std::make_unique<Simulation>(model());
    channel_ = std::make_unique<StateChannel>(model());
    start(recorder_);
}

StageCounts Stage::counts() const {
    StageCounts sum = before_;
    if (thread_.joinable()) {
        const TickState& s = channel_->state();
        add(sum, s.books, s.counters);
        add(sum, s.safety);
        add(sum, s.second.safety);  // zeros of one tool
    }
    return sum;
}

}  // namespace tissue::serve
