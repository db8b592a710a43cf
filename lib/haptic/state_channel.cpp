#include "haptic/state_channel.h"

namespace tissue {
namespace {

/// A state with all its storage allocated.
TickState empty_state(const HapticModel& model) {
    TickState state;
    std::size_t nodes = 0;
    for (const auto& mesh : model.meshes) nodes += static_cast<std::size_t>(mesh->springs.node_count());
    for (ToolTick* tool : {static_cast<ToolTick*>(&state), &state.second}) tool->contact_displacement_m.assign(model.meshes.size(), Point(Point::Zero(model.dimension())));
    state.nodes_m.assign(static_cast<std::size_t>(model.dimension()) * nodes, 0);
    return state;
}

/// displacement_m: displayed displacement of each mesh's nodes (Simulation::displayed).
void copy(const Simulation& simulation, int tool, const std::vector<NodeColumns>& displacement_m, ToolTick& to) noexcept {
    const TickRecord& record = simulation.record(tool);
    to.record = record;
    to.safety = simulation.safety(tool).counters();
    to.proxy_m = record.proxy_m;
    for (std::size_t m = 0; m < to.contact_displacement_m.size(); ++m) {
        const HapticMesh& mesh = *simulation.model().meshes[m];
        to.contact_displacement_m[m] = simulation.displacement_at_contact(m, tool);
        if (!mesh.energy_model || static_cast<int>(m) != record.mesh) continue;
        to.proxy_m = mesh.place_m;
        for (Eigen::Index k = 0; k < mesh.springs.facets().cols(); ++k) {
            const int node = mesh.springs.facets()(record.facet, k);
            to.proxy_m += record.weight[k] * (mesh.springs.rest().row(node) + displacement_m[m].row(node)).transpose();
        }
    }
}

void copy(const Simulation& simulation, const TickStatistics& books, TickState& state, std::vector<NodeColumns>& seen) noexcept {
    state.books = books;
    state.counters = simulation.counters();
    state.rested_s = simulation.rested_s();
    float* out = state.nodes_m.data();
    for (std::size_t m = 0; m < seen.size(); ++m) {
        const HapticMesh& mesh = *simulation.model().meshes[m];
        const NodeColumns &rest = mesh.springs.rest(), &u = seen[m];
        simulation.displayed(m, seen[m]);
        for (int n = 0; n < mesh.springs.node_count(); ++n)
            for (int axis = 0; axis < mesh.springs.dimension(); ++axis) *out++ = static_cast<float>(mesh.place_m[axis] + rest(n, axis) + u(n, axis));
    }
    copy(simulation, 0, seen, state);
    if (simulation.tool_count() > 1) copy(simulation, 1, seen, state.second);
}

}  // namespace

StateChannel::StateChannel(const HapticModel& model, int every, std::size_t times)
    : every_(every), latest_(empty_state(model)), times_(times) {
    for (const auto& mesh : model.meshes) seen_.emplace_back(NodeColumns::Zero(mesh->springs.node_count(), mesh->springs.dimension()));
}

bool StateChannel::before(Simulation& simulation) noexcept {
    if (reset_.exchange(false, std::memory_order_relaxed)) simulation.reset();
    return !paused_.load(std::memory_order_relaxed);
}

void StateChannel::after(const Simulation& simulation, const TickStatistics& books) noexcept {
    if (!books.left_out) times_.push(books.tick_us);
    if (++since_ < every_) return;
    since_ = 0;
    copy(simulation, books, latest_.back(), seen_);
    latest_.publish();
}

}  // namespace tissue
