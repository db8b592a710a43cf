#include "haptic/recorder.h"

#include <algorithm>
#include <chrono>

namespace tissue {
namespace {

constexpr std::size_t block_ticks = 1024;

constexpr int of_tissue = -1;  ///< Dataset::axes: one column per axis of the tissue

/// A dataset with one row per tick and `axes` columns (0: a plain list). value() takes its numbers from an `Of`.
template <class Of, class Number>
struct Dataset {
    const char* name;
    int axes;
    const char *units, *description;
    Number (*value)(const Of&, int axis);
};

double axis(const Point& p, int a) { return a < p.size() ? p[a] : 0; }

const Dataset<RecordedTick, double> of_loop[] = {
    {"/time", 0, "s", "scheduled time of each tick", [](const RecordedTick& k, int) { return k.time_s; }},
    {"/tick_us", 0, "us", "computation time of the tick", [](const RecordedTick& k, int) { return k.tick_us; }},
    {"/lateness_us", 0, "us", "start of the tick after its scheduled time", [](const RecordedTick& k, int) { return k.lateness_us; }},
};

const Dataset<RecordedTick, int> of_tissue_alone[] = {
    {"/reset", 0, "", "1 where every mesh was put to rest before the tick, by a call of reset", [](const RecordedTick& k, int) { return k.tool[0].reset ? 1 : 0; }},
};

const Dataset<TickRecord, double> of_tool[] = {
    {"/device_position", 3, "m", "position from the device", [](const TickRecord& t, int a) { return t.device_m[a]; }},
    {"/device_force", 3, "N", "force to the device", [](const TickRecord& t, int a) { return t.device_N[a]; }},
    {"/master", of_tissue, "m", "device position in the tissue's space", [](const TickRecord& t, int a) { return axis(t.master_m, a); }},
    {"/proxy", of_tissue, "m", "proxy, on the surface while in contact", [](const TickRecord& t, int a) { return axis(t.proxy_m, a); }},
    {"/contact_displacement", of_tissue, "m", "x_p - X_p of the learned mesh", [](const TickRecord& t, int a) { return axis(t.contact_displacement_m, a); }},
    {"/coupling_force", of_tissue, "N", "k_C (x_p - x_m), before safety and force scale", [](const TickRecord& t, int a) { return axis(t.coupling_N, a); }},
    {"/weight", 3, "1", "weights of the facet's nodes at the contact; for a segment the third is 0", [](const TickRecord& t, int a) { return t.weight[a]; }},
};

const Dataset<TickRecord, int> of_tool_whole[] = {
    {"/mesh", 0, "", "mesh in contact, -1 none", [](const TickRecord& t, int) { return t.mesh; }},
    {"/facet", 0, "", "facet of the boundary, -1 none", [](const TickRecord& t, int) { return t.facet; }},
    {"/set", 0, "", "spring set with the largest weight", [](const TickRecord& t, int) { return t.set; }},
    {"/slipping", 0, "", "1 where the contact slips along the surface", [](const TickRecord& t, int) { return t.slipping ? 1 : 0; }},
    {"/grasp", 0, "", "0 none, 1 requested, 2 the tool grasps the tissue", [](const TickRecord& t, int) { return t.grasped ? 2 : t.grasp ? 1 : 0; }},
    {"/status", 0, "", "0 done; without force: 1 the position was refused, 2 not yet outside, 3 folded, 4 diverged", [](const TickRecord& t, int) { return static_cast<int>(t.status); }},
    {"/fault", 0, "", "1 where the input was refused", [](const TickRecord& t, int) { return t.fault() ? 1 : 0; }},
};

}  // namespace

/// Calls use(name, dataset, of) for each dataset; of(tick) is the argument of the dataset's value().
template <class Use>
void Recorder::each_dataset(const Use& use) const {
    const auto whole = [](const RecordedTick& k) -> const RecordedTick& { return k; };
    for (const auto& d : of_loop) use(d.name, d, whole);
    for (const auto& d : of_tissue_alone) use(d.name, d, whole);
    for (int t = 0; t < tools_; ++t) {
        const std::string group = recorded_tool(t);
        const auto tool = [t](const RecordedTick& k) -> const TickRecord& { return k.tool[static_cast<std::size_t>(t)]; };
        for (const auto& d : of_tool) use(group + d.name, d, tool);
        for (const auto& d : of_tool_whole) use(group + d.name, d, tool);
    }
}

const char* recorded_tool(int tool) { return tool == 0 ? "" : "/second"; }

Recorder::Recorder(const std::string& file, int dimension, const Provenance& provenance, int tools, std::size_t ring)
    : ring_(ring), dimension_(dimension), tools_(tools), out_(file, "recording", provenance) {
    block_.reserve(block_ticks);
    each_dataset([&](const std::string& name, const auto& d, const auto&) { out_.begin_rows(name, columns(d.axes), d.units, d.description); });
    thread_ = std::thread([this] { run(); });
}

Recorder::~Recorder() {
    done_.store(true);
    if (thread_.joinable()) thread_.join();
}

void Recorder::after(const Simulation& simulation, const TickStatistics& books) noexcept {
    if (books.left_out) return;
    RecordedTick row;
    for (int t = 0; t < tools_; ++t) row.tool[static_cast<std::size_t>(t)] = simulation.record(t);
    row.time_s = books.time_s, row.tick_us = books.tick_us, row.lateness_us = books.lateness_us;
    push(row, !books.clock);
}

void Recorder::push(const RecordedTick& tick, bool waits) noexcept {
    while (!ring_.push(tick)) {
        if (!waits) {
            dropped_.fetch_add(1, std::memory_order_relaxed);
            return;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

void Recorder::drain() {
    RecordedTick tick;
    while (ring_.pop(tick)) {
        if (error_) continue;
        block_.push_back(tick);
        if (block_.size() == block_ticks) write_block();
    }
}

void Recorder::write_block() {
    try {
        each_dataset([&](const std::string& name, const auto& d, const auto& of) {
            std::vector<decltype(d.value(of(block_[0]), 0))> values;
            values.reserve(block_.size() * static_cast<std::size_t>(std::max(columns(d.axes), 1)));
            for (const RecordedTick& tick : block_)
                for (int a = 0; a < std::max(columns(d.axes), 1); ++a) values.push_back(d.value(of(tick), a));
            out_.append_rows(name, values);
        });
    } catch (...) {
        error_ = std::current_exception();
    }
    block_.clear();
}

void Recorder::run() {
    while (!done_.load()) {
        drain();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    drain();
    if (!error_) write_block();
}

void Recorder::close(const Simulation& simulation) {
    done_.store(true);
    if (thread_.joinable()) thread_.join();
    if (error_) std::rethrow_exception(error_);
    const HapticModel& model = simulation.model();
    out_.write_texts("/set_names", model.set_names, "spring sets of the learned mesh");
    out_.attribute("/", "study", model.study);
    out_.attribute("/", "dropped_samples", static_cast<double>(dropped()));
    out_.attribute("/", "dt_s", model.options.dt_s);
    out_.attribute("/", "innovation", *model.options.innovation);
    for (const auto& mesh : model.meshes) out_.attribute("/", "dynamics_" + mesh->name, mesh->dynamics);
    for (int t = 0; t < tools_; ++t) {
        const std::string group = t == 0 ? "/" : recorded_tool(t);
        const HapticOptions& options = simulation.options(t);
        out_.attribute(group, "force_scale", options.map.force_scale);
        out_.attribute(group, "position_scale", options.map.scale);
        out_.attribute(group, "force_max_N", options.safety.force_max_N);
    }
    out_.commit();
}

}  // namespace tissue
