#include "stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "error.h"
#include "hand.h"
#include "springs/energy_model_at_radius.h"
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

void add(StageCounts& sum, const TickStatistics& books, const HapticCounters& h) {
    sum.ticks += books.ticks;
    sum.misses += books.misses;
    sum.misses_program += books.misses_program;
    sum.lost_s += h.lost_s;
    sum.folded += h.folded;
    sum.unstable += h.unstable;
}

/// The study's name; a name that is taken gets a number: "paper (2)".
std::string name_for(const std::string& study, const std::vector<std::string>& taken) {
    std::string name = study;
    for (int k = 2; std::find(taken.begin(), taken.end(), name) != taken.end(); ++k) name = fmt::format("{} ({})", study, k);
    return name;
}

/// Options for an energy model that is served beside spring sets: those of spring sets are removed.
HapticOptions without_sets(HapticOptions options, const TissueModel& tissue) {
    options.sets.clear();
    options.select_by = SelectBy::displacement;
    options.innovation.reset();
    // in the plane the heuristic mesh has a coupling
    if (tissue.mesh.is_solid() || !options.heuristic_mesh) options.coupling_ratio.reset();
    return options;
}

/// Result of a step; an error about the model names its file.
template <class Step>
auto named(const std::string& file, const Step& step) {
    try {
        return step();
    } catch (const MismatchError& e) {
        throw MismatchError(file + ": " + e.what());
    }
}

}  // namespace

Stage::Stage(const std::vector<std::string>& files, const StageOptions& options) : options_(options) {
    if (!options_.hidden.empty()) {
        if (files.size() != 1) throw MismatchError("one model learns, not one of several");
        if (options_.haptic.tools > 1) throw MismatchError("--tools: a model learns from one tool");
        if (!all_default(options_.haptic.tool)) throw MismatchError("--tool: a model that learns while it plays has its own disc");
        lesson_ = std::make_unique<Lesson>(files.front(), options_.hidden);
        // the FE reference is of the tissue that the model was trained on, not of the target tissue
        TissueModel tissue = lesson_->adaptation().base();
        tissue.contact_force_N.resize(0, tissue.contact_force_N.cols());
        served_.push_back({files.front(), options_.haptic.tool});
        names_.push_back(tissue.study);
        make(served_.back(), tissue, tissue, live_options(options_.haptic, lesson_->adaptation()), {}, learned_field(lesson_->adaptation()));
    } else {
        std::vector<TissueModel> tissues;
        for (const std::string& file : files) tissues.push_back(read_model(file));
        some_sets_ = std::any_of(tissues.begin(), tissues.end(), [](const TissueModel& t) { return !t.energy_model; });
        for (std::size_t k = 0; k < files.size(); ++k) {
            served_.push_back({files[k], options_.haptic.tool});
            names_.push_back(name_for(tissues[k].study, names_));
            make(served_.back(), tissues[k]);
        }
        for (std::size_t k = 0; k < files.size() && all_default(options_.haptic.tool); ++k) serve_other_tools(files[k], tissues[k]);
    }
    if (!options_.surface.empty()) {
        refuse_vtk(options_.surface);
        carried_ = read_surface_or_msh(options_.surface, options_.surface);
        carry(served_.front());
    }
    take_pointers();
    simulation_ = std::make_unique<Simulation>(model());
    channel_ = std::make_unique<StateChannel>(model());
    if (!lesson_) return;
    learner_ = std::make_unique<Learner>(*served_.front().model, lesson_->adaptation());
    lesson_->listen(*learner_);
}

/// A model of a file, with what lies beside the file: FE displacements and errors.
void Stage::make(Served& served, const TissueModel& tissue) {
    const std::optional<LearnedField> learned = learned_field(served.file);
    // the FE reference is of the trained tissue, not of the adapted one
    const TissueModel of_tool = named(served.file, [&] { return with_tool(tissue, served.tool[0]); });
    const FeCases fe = learned ? FeCases() : read_fe_cases(served.file, of_tool);
    KnownErrors known = learned ? KnownErrors() : read_reference_errors(served.file, of_tool);
    for (const std::string& warning : {fe.warning, known.warning})
        if (!warning.empty()) warnings_.push_back(warning);
    HapticOptions haptic = some_sets_ && tissue.energy_model ? without_sets(options_.haptic, tissue) : options_.haptic;
    haptic.tool = served.tool;
    make(served, tissue, of_tool, haptic, fe.displacement_m, learned);
    served.scene->know(std::move(known.all));
}

/// of_tool: the model with the first tool.
void Stage::make(Served& served, const TissueModel& tissue, const TissueModel& of_tool, const HapticOptions& haptic, const std::vector<NodeField>& fe_displacement_m,
                 std::optional<LearnedField> learned) const {
    named(served.file, [&] {
        served.model = std::make_unique<HapticModel>(tissue, haptic);
        served.scene = std::make_unique<Scene>(of_tool, *served.model, fe_displacement_m, std::move(learned));
    });
}

/// Has the first model, with any tool, carry the surface of the options.
void Stage::carry(Served& served) const {
    if (!carried_ || served.file != served_.front().file) return;
    named(served.file, [&] { served.scene->carry(carried_surface(served.scene->mesh(), *carried_, options_.unit_m)); });
}

/// Adds a model that was trained under several discs with each of these, and with balls whose contact is in their range.
void Stage::serve_other_tools(const std::string& file, const TissueModel& tissue) {
    if (!tissue.energy_model || tissue.energy_model->sizes.empty()) return;
    const EnergyModel& energy_model = *tissue.energy_model;
    std::vector<ToolChoice> tools;
    for (const double radius_m : energy_model.sizes.radii_m)
        if (radius_m != energy_model.disc_radius_m) tools.push_back({ToolChoice::Shape::disc, radius_m});
    for (const double radius_m : {0.003, 0.004, 0.006, 0.008, 0.010, 0.015, 0.020}) {
        const double contact_m = BallContact::half_in * radius_m;
        if (energy_model.relaxation.empty() && contact_m >= energy_model.sizes.radii_m.minCoeff() && contact_m <= energy_model.sizes.radii_m.maxCoeff()) tools.push_back({ToolChoice::Shape::ball, radius_m});
    }
    for (const ToolChoice& tool : tools) {
        names_.push_back(name_for(fmt::format("{}, {} of {:g} mm", tissue.study, to_string(tool.shape), 1e3 * tool.radius_m), names_));
        served_.push_back({file, {tool}});
    }
}

/// Makes pointers in the model's space, above its middle and side by side.
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
        auto hidden = std::make_unique<TargetTissue>(std::move(devices_.front()), lesson_->hidden(), hand);
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
    TickStatistics books;
    books.ticks = report_.ticks;
    books.misses = report_.misses;
    books.misses_program = report_.misses_program;
    if (learner_) learner_->stop();
    add(before_, books, simulation_->counters());
    for (int tool = 0; tool < tools(); ++tool) add(before_, simulation_->safety(tool).counters());
}

void Stage::turn_to(int model_index) {
    Served& next = served_[static_cast<std::size_t>(model_index)];
    if (!next.model) {
        Served made{next.file, next.tool};
        make(made, read_model(made.file));
        carry(made);
        next = std::move(made);
    }
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
        add(sum, s.second.safety);  // zero where there is one tool
    }
    return sum;
}

}  // namespace tissue::serve
