#include "haptic/recorder.h"

#include <algorithm>
#include <chrono>

namespace tissue {
namespace {

constexpr std::size_t block_ticks = 1024;

constexpr int of_tissue = -1;  ///< as many columns as the tissue has axes

/// A dataset of real numbers: one row a tick, `axes` columns (0: none, a plain list).
struct Numbers {
    const char* name;
    int axes;
    const char *units, *description;
    double (*value)(const RecordedTick&, int axis);
};

/// A dataset of whole numbers: one a tick.
struct Integers {
    const char *name, *description;
    int (*value)(const RecordedTick&);
};

double axis(const Point& p, int a) { return a < p.size() ? p[a] : 0; }

const Numbers numbers[] = {
    {"/time", 0, "s", "of each tick on the schedule", [](const RecordedTick& k, int) { return k.tick.time_s; }},
    {"/device_position", 3, "m", "as the device gave it", [](const RecordedTick& k, int a) { return k.tick.device_m[a]; }},
    {"/device_force", 3, "N", "as the device got it", [](const RecordedTick& k, int a) { return k.tick.device_N[a]; }},
    {"/master", of_tissue, "m", "device position in the tissue's space", [](const RecordedTick& k, int a) { return axis(k.tick.master_m, a); }},
    {"/proxy", of_tissue, "m", "on the surface while in contact", [](const RecordedTick& k, int a) { return axis(k.tick.proxy_m, a); }},
    {"/contact_displacement", of_tissue, "m", "x_p - X_p of the learned mesh", [](const RecordedTick& k, int a) { return axis(k.tick.contact_displacement_m, a); }},
    {"/coupling_force", of_tissue, "N", "k_C (x_p - x_m), before safety and force scale", [](const RecordedTick& k, int a) { return axis(k.tick.coupling_N, a); }},
    {"/weight", 3, "1", "of the facet's nodes at the contact; of a segment the third is 0", [](const RecordedTick& k, int a) { return k.tick.weight[a]; }},
    {"/tick_us", 0, "us", "work of the tick", [](const RecordedTick& k, int) { return k.tick_us; }},
    {"/lateness_us", 0, "us", "start of the tick after its place on the schedule", [](const RecordedTick& k, int) { return k.lateness_us; }},
};

const Integers integers[] = {
    {"/mesh", "pressed mesh, -1 none", [](const RecordedTick& k) { return k.tick.mesh; }},
    {"/facet", "of the boundary, -1 none", [](const RecordedTick& k) { return k.tick.facet; }},
    {"/set", "spring set with the largest share", [](const RecordedTick& k) { return k.tick.set; }},
    {"/slipping", "1 where the contact went along the surface", [](const RecordedTick& k) { return k.tick.slipping ? 1 : 0; }},
    {"/status", "0 done; without force: 1 the position was refused, 2 not yet outside, 3 folded, 4 diverged", [](const RecordedTick& k) { return static_cast<int>(k.tick.status); }},
    {"/fault", "1 where the input was refused", [](const RecordedTick& k) { return k.tick.fault() ? 1 : 0; }},
    {"/reset", "1 where every mesh was put to rest before the tick, by a reset from outside", [](const RecordedTick& k) { return k.tick.reset ? 1 : 0; }},
};

}  // namespace

Recorder::Recorder(const std::string& file, int dimension, const Provenance& provenance, std::size_t ring)
    : ring_(ring), dimension_(dimension), out_(file, "recording", provenance) {
    block_.reserve(block_ticks);
    for (const Numbers& n : numbers) out_.begin_rows(n.name, columns(n.axes), n.units, n.description);
    for (const Integers& n : integers) out_.begin_rows(n.name, 0, "", n.description);
    thread_ = std::thread([this] { run(); });
}

Recorder::~Recorder() {
    done_.store(true);
    if (thread_.joinable()) thread_.join();
}

void Recorder::after(const Simulation& simulation, const TickBooks& books) noexcept {
    if (books.left_out) return;
    RecordedTick row{simulation.record(), books.tick_us, books.lateness_us};
    row.tick.time_s = books.time_s;
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
        std::vector<double> values;
        for (const Numbers& n : numbers) {
            values.clear();
            for (const RecordedTick& tick : block_)
                for (int a = 0; a < std::max(columns(n.axes), 1); ++a) values.push_back(n.value(tick, a));
            out_.append_rows(n.name, values);
        }
        std::vector<int> whole;
        for (const Integers& n : integers) {
            whole.clear();
            for (const RecordedTick& tick : block_) whole.push_back(n.value(tick));
            out_.append_rows(n.name, whole);
        }
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

void Recorder::close(const HapticModel& model) {
    done_.store(true);
    if (thread_.joinable()) thread_.join();
    if (error_) std::rethrow_exception(error_);
    out_.write_texts("/set_names", model.set_names, "of the learned mesh");
    out_.attribute("/", "study", model.study);
    out_.attribute("/", "dropped_samples", static_cast<double>(dropped()));
    out_.attribute("/", "force_scale", model.options.map.force_scale);
    out_.attribute("/", "position_scale", model.options.map.scale);
    out_.attribute("/", "dt_s", model.options.dt_s);
    out_.attribute("/", "innovation", *model.options.innovation);
    out_.attribute("/", "force_max_N", model.options.safety.force_max_N);
    for (const auto& mesh : model.meshes) out_.attribute("/", "dynamics_" + mesh->name, mesh->dynamics);
    out_.commit();
}

}  // namespace tissue
