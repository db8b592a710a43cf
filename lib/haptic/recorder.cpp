#include "haptic/recorder.h"

#include <chrono>
#include <functional>

namespace tissue {

Recorder::Recorder(const std::string& file, const Provenance& provenance, std::size_t ring)
    : ring_(ring), out_(file, "recording", provenance), thread_([this] { run(); }) {}

Recorder::~Recorder() {
    done_.store(true);
    if (thread_.joinable()) thread_.join();
}

void Recorder::after(const Simulation& simulation, const TickBooks& books) noexcept {
    if (books.left_out) return;
    RecordedTick row{simulation.record(), books.tick_us, books.lateness_us};
    row.tick.time_s = books.time_s;
    push(row);
}

void Recorder::drain() {
    RecordedTick tick;
    while (ring_.pop(tick)) kept_.push_back(tick);
}

void Recorder::run() {
    while (!done_.load()) {
        drain();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    drain();
}

void Recorder::close(const HapticModel& model) {
    done_.store(true);
    if (thread_.joinable()) thread_.join();

    const auto n = static_cast<Eigen::Index>(kept_.size());
    const auto row = [&](Eigen::Index k) -> const RecordedTick& { return kept_[static_cast<std::size_t>(k)]; };
    const auto numbers = [&](const std::string& name, const std::string& units, const std::string& description,
                             const std::function<double(const RecordedTick&)>& value) {
        Eigen::VectorXd values(n);
        for (Eigen::Index k = 0; k < n; ++k) values[k] = value(row(k));
        out_.write(name, values, units, description);
    };
    const auto vectors = [&](const std::string& name, int axes, const std::string& units, const std::string& description,
                             const std::function<double(const RecordedTick&, int)>& value) {
        NodeField values(n, axes);
        for (Eigen::Index k = 0; k < n; ++k)
            for (int a = 0; a < axes; ++a) values(k, a) = value(row(k), a);
        out_.write(name, values, units, description);
    };
    const auto integers = [&](const std::string& name, const std::string& description,
                              const std::function<int(const RecordedTick&)>& value) {
        std::vector<int> values;
        for (const RecordedTick& k : kept_) values.push_back(value(k));
        out_.write_integers(name, {kept_.size()}, values, description);
    };
    numbers("/time", "s", "of each tick on the schedule", [](const RecordedTick& k) { return k.tick.time_s; });
    vectors("/device_position", 3, "m", "as the device gave it", [](const RecordedTick& k, int a) { return k.tick.device_m[a]; });
    vectors("/device_force", 3, "N", "as the device got it", [](const RecordedTick& k, int a) { return k.tick.device_N[a]; });
    vectors("/master", 2, "m", "device position in the plane of the tissue", [](const RecordedTick& k, int a) { return k.tick.master_m[a]; });
    vectors("/proxy", 2, "m", "on the outline while in contact", [](const RecordedTick& k, int a) { return k.tick.proxy_m[a]; });
    vectors("/contact_displacement", 2, "m", "x_p - X_p of the learned mesh", [](const RecordedTick& k, int a) { return k.tick.contact_displacement_m[a]; });
    vectors("/coupling_force", 2, "N", "k_C (x_p - x_m), before safety and force scale", [](const RecordedTick& k, int a) { return k.tick.coupling_N[a]; });
    integers("/mesh", "pressed mesh, -1 none", [](const RecordedTick& k) { return k.tick.mesh; });
    integers("/segment", "of the outline, -1 none", [](const RecordedTick& k) { return k.tick.segment; });
    numbers("/weight", "1", "w(1) of the contact on its segment", [](const RecordedTick& k) { return k.tick.w; });
    integers("/set", "spring set with the largest share", [](const RecordedTick& k) { return k.tick.set; });
    integers("/fault", "1 where the input was refused", [](const RecordedTick& k) { return k.tick.fault ? 1 : 0; });
    numbers("/tick_us", "us", "work of the tick", [](const RecordedTick& k) { return k.tick_us; });
    numbers("/lateness_us", "us", "start of the tick after its place on the schedule", [](const RecordedTick& k) { return k.lateness_us; });
    out_.write_texts("/set_names", model.set_names, "of the learned mesh");
    out_.attribute("/", "study", model.study);
    out_.attribute("/", "dropped_samples", static_cast<double>(dropped()));
    out_.attribute("/", "force_scale", model.options.map.force_scale);
    out_.attribute("/", "position_scale", model.options.map.scale);
    out_.attribute("/", "dt_s", model.options.dt_s);
    out_.attribute("/", "innovation", model.options.innovation);
    out_.attribute("/", "force_max_N", model.options.safety.force_max_N);
    for (const auto& mesh : model.meshes) out_.attribute("/", "dynamics_" + mesh->name, mesh->dynamics);
    out_.commit();
}

}  // namespace tissue
