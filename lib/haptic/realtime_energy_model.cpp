#include "haptic/realtime_energy_model.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "error.h"
#include "haptic/cell_kernels.h"
#include "springs/region_area.h"

namespace tissue {
namespace {

constexpr int chunk = kernel::cells_at_once;

const EnergyModel& energy_model_of(const TissueModel& model) {
    if (!model.energy_model) throw MismatchError("the model is not an energy model");
    return *model.energy_model;
}

}  // namespace

RealtimeEnergyModel::RealtimeEnergyModel(const TissueModel& model, const RealtimeMesh& springs, double ball_m) : springs_(springs) {
    const EnergyModel& energy_model = energy_model_of(model);
    contacts_.emplace_back(model.mesh, energy_model, ball_m);
    if (!springs.law().curve()) throw MismatchError(fmt::format("springs of an energy model must be geometric, not {}", springs.law().name()));
    if (!(*springs.law().curve() == energy_model.curve)) throw MismatchError("the mesh and the energy model have different spring curves");
    const TissueEnergy energy(model.mesh, energy_model);
    now_ = {energy_model.constants, energy_model.patch, energy_model.contact_log_scale.size() > 0 ? energy_model.contact_log_scale : Eigen::VectorXd::Zero(model.mesh.node_count())};
    contacts_.front().scale(now_.contact_log_scale);

    theta_ = springs.to_slots(energy_model.constants.head(energy.kinds().front()->count()));
    spring_of_slot_.assign(static_cast<std::size_t>(springs.slot_count()), -1);
    for (std::size_t s = 0; s < springs.slot_of_spring().size(); ++s) spring_of_slot_[static_cast<std::size_t>(springs.slot_of_spring()[s])] = static_cast<Eigen::Index>(s);
    if (model.mesh.is_solid()) {
        add_cubes(model, static_cast<const CellVolumes&>(*energy.kinds()[1]), energy.first_of(1));
        const Embedding& embedding = model.mesh.embedding;
        supports_.begin.push_back(0);
        for (int node : model.mesh.fixed) {
            for (int k = 0; k < 8; ++k) {
                if (std::abs(embedding.weight(node, k)) < 1e-12) continue;
                supports_.corner.push_back(embedding.corner(node, k));
                supports_.weight.push_back(embedding.weight(node, k));
            }
            supports_.begin.push_back(static_cast<int>(supports_.corner.size()));
        }
        supports_.first_constant = energy.first_of(2);
        const auto k = energy_model.constants.tail(energy.kinds()[2]->count());
        supports_.gain.assign(k.begin(), k.end());
    } else {
        for (std::size_t k = 1; k < energy.kinds().size(); ++k) {
            const Elements& kind = *energy.kinds()[k];
            add_plane_cells(kind, energy_model.constants.segment(energy.first_of(k), kind.count()), energy.first_of(k));
        }
    }
    relaxation_ = energy_model.relaxation;
    if (!relaxation_.empty() && (relaxation_.share.rows() != energy_model.constants.size() || relaxation_.share.cols() != relaxation_.branches() ||
                                 relaxation_.contact_share.size() != relaxation_.branches()))
        throw MismatchError("the relative moduli of the energy model do not match its constants");
    first_square_ = springs.slot_count();
    first_region_ = first_square_ + squares_.count;
    first_cube_ = first_region_ + static_cast<int>(regions_.size());
}

RealtimeEnergyModel::RealtimeEnergyModel(const RealtimeEnergyModel& other)
    : springs_(other.springs_), now_(other.now_), theta_(other.theta_), relaxation_(other.relaxation_), first_square_(other.first_square_), first_region_(other.first_region_),
      first_cube_(other.first_cube_), spring_of_slot_(other.spring_of_slot_), squares_(other.squares_), regions_(other.regions_), walk_(other.walk_),
      cubes_(other.cubes_), supports_(other.supports_), contacts_(other.contacts_) {}

void RealtimeEnergyModel::fields(StateBytes& state) noexcept {
    state(now_.constants, now_.patch.log_N_m, now_.contact_log_scale, theta_, squares_.gain, cubes_.gain, supports_.gain);
    for (Region& region : regions_) state(region.gain);
    if (state.reads()) contacts_become();
}

void RealtimeEnergyModel::become(const EnergyModelStiffness& stiffness) noexcept {
    const auto grown = [&](Eigen::Index c) { return stiffness.constants[c] / now_.constants[c]; };
    for (std::size_t slot = 0; slot < spring_of_slot_.size(); ++slot)
        if (spring_of_slot_[slot] >= 0) theta_[static_cast<Eigen::Index>(slot)] = stiffness.constants[spring_of_slot_[slot]];
    for (std::size_t k = 0; k < squares_.constant.size(); ++k)
        if (squares_.constant[k] >= 0) squares_.gain[k] *= grown(squares_.constant[k]);
    for (Region& region : regions_) region.gain *= grown(region.constant);
    for (std::size_t k = 0; k < cubes_.constant.size(); ++k)
        if (cubes_.constant[k] >= 0) cubes_.gain[k] *= grown(cubes_.constant[k]);
    for (std::size_t k = 0; k < supports_.gain.size(); ++k) supports_.gain[k] = stiffness.constants[supports_.first_constant + static_cast<Eigen::Index>(k)];
    now_.constants = stiffness.constants;
    now_.patch = stiffness.patch;
    now_.contact_log_scale = stiffness.contact_log_scale;
    contacts_become();
}

void RealtimeEnergyModel::add_tool(const SpringMesh& mesh, const EnergyModel& energy_model, double ball_m) {
    contacts_.emplace_back(mesh, energy_model, ball_m);
    contacts_.back().scale(now_.contact_log_scale);
}

void RealtimeEnergyModel::contacts_become() noexcept {
    contacts_.front().become(now_.patch, now_.contact_log_scale);
    for (std::size_t k = 1; k < contacts_.size(); ++k) contacts_[k].scale(now_.contact_log_scale);
}

BranchMemory RealtimeEnergyModel::memory(double dt_s) const {
    if (relaxation_.empty()) return {};
    std::vector<Eigen::Index> constant = spring_of_slot_;
    constant.insert(constant.end(), squares_.constant.begin(), squares_.constant.end());
    for (const Region& region : regions_) constant.push_back(region.constant);
    constant.insert(constant.end(), cubes_.constant.begin(), cubes_.constant.end());
    Eigen::MatrixXd share(static_cast<Eigen::Index>(constant.size()), relaxation_.branches());
    for (std::size_t i = 0; i < constant.size(); ++i)  // slots without an element get those of the first constant
        share.row(static_cast<Eigen::Index>(i)) = relaxation_.share.row(std::max<Eigen::Index>(constant[i], 0));
    return {relaxation_.tau_s, share, dt_s};
}

ToolMemory RealtimeEnergyModel::tool_memory(double dt_s) const {
    return {relaxation_.tau_s, relaxation_.contact_share, dt_s};
}

void RealtimeEnergyModel::add_plane_cells(const Elements& kind, const Eigen::VectorXd& constants, Eigen::Index first) {
    if (kind.kind() == "region") {
        std::vector<std::array<int, 2>> edges;
        for (const auto& [i, j] : static_cast<const RegionArea&>(kind).edges()) edges.push_back({kind.nodes()(0, i), kind.nodes()(0, j)});
        add_region(edges, constants[0], first);
    } else if (!add_squares(kind, constants, first)) {
        for (int e = 0; e < kind.count(); ++e) {
            std::vector<std::array<int, 2>> edges;
            for (Eigen::Index c = 0, n = kind.nodes().cols(); c < n; ++c) edges.push_back({kind.nodes()(e, c), kind.nodes()(e, (c + 1) % n)});
            add_region(edges, constants[e], first + e);
        }
    }
}

/// False where the cells are not squares with equal offsets between their nodes, as in a lattice.
bool RealtimeEnergyModel::add_squares(const Elements& cells, const Eigen::VectorXd& constants, Eigen::Index first_constant) {
    const Cells& nodes = cells.nodes();
    if (nodes.rows() == 0 || nodes.cols() != 4) return false;
    const int first = nodes.col(0).minCoeff(), count = nodes.col(0).maxCoeff() - first + 1;
    std::vector<bool> taken(static_cast<std::size_t>(count), false);
    for (int e = 0; e < cells.count(); ++e) {
        for (int corner = 1; corner < 4; ++corner)
            if (nodes(e, corner) - nodes(e, 0) != nodes(0, corner) - nodes(0, 0)) return false;
        const auto k = static_cast<std::size_t>(nodes(e, 0) - first);
        if (taken[k]) return false;
        taken[k] = true;
    }
    const auto n = static_cast<std::size_t>(count);
    squares_ = {first, count, nodes(0, 1) - nodes(0, 0), nodes(0, 2) - nodes(0, 0), nodes(0, 3) - nodes(0, 0), {}, {}, {}, {}, {}, {}};
    squares_.constant.assign(n, -1);
    for (std::vector<double>* list : {&squares_.px, &squares_.py, &squares_.qx, &squares_.qy, &squares_.gain}) list->assign(n, 0);
    for (int e = 0; e < cells.count(); ++e) {
        const auto k = static_cast<std::size_t>(nodes(e, 0) - first);
        const Eigen::RowVector2d p = springs_.rest().row(nodes(e, 2)) - springs_.rest().row(nodes(e, 0)),
                                 q = springs_.rest().row(nodes(e, 3)) - springs_.rest().row(nodes(e, 1));
        squares_.px[k] = p.x();
        squares_.py[k] = p.y();
        squares_.qx[k] = q.x();
        squares_.qy[k] = q.y();
        squares_.constant[k] = first_constant + e;
        squares_.gain[k] = constants[e] / (2 * (p.x() * q.y() - p.y() * q.x()));
    }
    return true;
}

void RealtimeEnergyModel::add_region(const std::vector<std::array<int, 2>>& edges, double constant, Eigen::Index index) {
    std::multimap<int, int> next;
    for (const auto& [i, j] : edges) next.emplace(i, j);
    const NodeColumns& rest = springs_.rest();
    const auto begin = static_cast<int>(walk_.size());
    double twice_area = 0;
    while (!next.empty()) {
        std::vector<int> walk = {next.begin()->first};
        for (auto edge = next.begin(); edge != next.end(); edge = next.find(walk.back())) {
            walk.push_back(edge->second);
            next.erase(edge);
        }
        const std::size_t n = walk.size() - 1;  // the last node of a walk is its first
        for (std::size_t k = 0; k < n; ++k) {
            const int before = walk[(k + n - 1) % n], at = walk[k], after = walk[k + 1];
            const Eigen::RowVector2d span = rest.row(after) - rest.row(before), from = rest.row(at) - rest.row(walk[0]);
            walk_.push_back({at, before, after, span.x(), span.y()});
            twice_area += (from.x() * span.y() - from.y() * span.x()) / 2;
        }
    }
    regions_.push_back({begin, static_cast<int>(walk_.size()), constant / (2 * twice_area), index});
}

void RealtimeEnergyModel::add_cubes(const TissueModel& model, const CellVolumes& cells, Eigen::Index first_constant) {
    const Cells& nodes = cells.nodes();
    const Embedding& embedding = model.mesh.embedding;
    cubes_.per_m = 1 / embedding.spacing_m;
    constexpr int most_missing = 12;  // a run ends at a larger gap of missing cubes
    int before = -1;
    for (int e = 0; e < cells.count(); ++e) {
        int row[8];
        for (int c = 0; c < 8; ++c) row[c] = springs_.rows().of(nodes(e, c));
        for (int c = 0; c < 8; ++c)
            if (row[c | 1] != row[c & 6] + 1) throw MismatchError(fmt::format("the nodes of cube {} are not numbered as those of a lattice", e));
        if (row[0] <= before) throw MismatchError(fmt::format("cube {} is not in order after the one before", e));
        before = row[0];
        bool goes_on = !cubes_.runs.empty();
        if (goes_on) {
            Cubes::Run& run = cubes_.runs.back();
            const int missing = row[0] - (run.first_row + run.count);
            goes_on = missing <= most_missing;
            for (int c = 0; c < 8; ++c) goes_on = goes_on && row[c] - row[0] == run.corner[c];
            if (goes_on) run.count += missing + 1;
        }
        if (!goes_on) {
            cubes_.runs.push_back({row[0], cubes_.count(), 1, {}});
            for (int c = 0; c < 8; ++c) cubes_.runs.back().corner[c] = row[c] - row[0];
        }
        Cubes::Run& run = cubes_.runs.back();
        const auto slot = static_cast<std::size_t>(run.first_slot + run.count - 1);
        cubes_.gain.resize(slot + 1, 0);
        cubes_.constant.resize(slot + 1, -1);
        cubes_.constant[slot] = first_constant + e;
        for (std::size_t i = 0; i < 3; ++i) {
            cubes_.centroid[i].resize(slot, 0);
            cubes_.centroid[i].push_back(embedding.centroid(e, static_cast<Eigen::Index>(i)));
        }
        cubes_.gain[slot] = now_.constants[first_constant + e] * cells.volumes()[e];
    }
}

RealtimeEnergyModel::Scratch RealtimeEnergyModel::scratch() const {
    const LatticeRows& rows = springs_.rows();
    NodeColumns zero(0, 0);
    if (!rows.by_node()) zero.setZero(rows.count(), springs_.dimension());
    return {zero, zero};
}

void RealtimeEnergyModel::force(const NodeColumns& u, NodeColumns& f, Scratch& scratch) const noexcept {
    all_force(u, f, scratch, nullptr);
}

void RealtimeEnergyModel::force(const NodeColumns& u, NodeColumns& f, Scratch& scratch, BranchMemory& memory) const noexcept {
    all_force(u, f, scratch, memory.empty() ? nullptr : &memory);
}

void RealtimeEnergyModel::all_force(const NodeColumns& u, NodeColumns& f, Scratch& scratch, BranchMemory* memory) const noexcept {
    if (springs_.rows().by_node()) {
        elements_force(u, f, memory);
    } else {
        springs_.rows().scatter(u, scratch.u);
        elements_force(scratch.u, scratch.f, memory);
        springs_.rows().gather(scratch.f, f);
    }
    supports_force(u, f);
}

/// u and f by row.
void RealtimeEnergyModel::elements_force(const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept {
    springs_.force(theta_, u, f, memory);
    squares_force(u, f, memory);
    regions_force(u, f, memory);
    cubes_force(u, f, memory);
}

void RealtimeEnergyModel::regions_force(const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept {
    int element = first_region_;
    for (const Region& region : regions_) {
        double grown = twice_growth(region, u);
        if (memory) {
            const double now = grown;
            memory->step(element++, 1, &now, &grown);
        }
        const double pull = region.gain * grown;
        for (int k = region.begin; k < region.end; ++k) {
            const Step& step = walk_[static_cast<std::size_t>(k)];
            f(step.node, 0) += pull * (step.y + u(step.after, 1) - u(step.before, 1));
            f(step.node, 1) -= pull * (step.x + u(step.after, 0) - u(step.before, 0));
        }
    }
}

/// For n cubes of a run from number `done` on: J - 1 into grown, and the corner forces of a unit pull into g.
void RealtimeEnergyModel::cubes_grown(const Cubes::Run& run, int done, int n, const NodeColumns& u, double* g, double* grown) const noexcept {
    const int slot = run.first_slot + done, row = run.first_row + done, *corner = run.corner;
    const double *ux = u.col(0).data() + row, *uy = u.col(1).data() + row, *uz = u.col(2).data() + row;
    const std::vector<double>* at = cubes_.centroid;
    kernel::cubes_grown(n, cubes_.per_m, at[0].data() + slot, at[1].data() + slot, at[2].data() + slot, ux, uy, uz, corner[2], corner[4], corner[6], g, grown);
}

void RealtimeEnergyModel::cubes_force(const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept {
    constexpr int few = kernel::cubes_at_once;
    alignas(64) double g[24 * few], grown[few], felt[few];
    for (const Cubes::Run& run : cubes_.runs)
        for (int done = 0; done < run.count; done += few) {
            const int n = std::min(few, run.count - done), slot = run.first_slot + done, row = run.first_row + done, *corner = run.corner;
            const double* gain = cubes_.gain.data() + slot;
            if (memory) {
                cubes_grown(run, done, n, u, g, grown);
                memory->step(first_cube_ + slot, n, grown, felt);
                kernel::times(n, gain, felt, 24, few, g);
            } else {
                const std::vector<double>* at = cubes_.centroid;
                kernel::cubes(n, cubes_.per_m, at[0].data() + slot, at[1].data() + slot, at[2].data() + slot, gain, u.col(0).data() + row, u.col(1).data() + row,
                              u.col(2).data() + row, corner[2], corner[4], corner[6], g);
            }
            for (int d = 0; d < 3; ++d)
                for (int c = 0; c < 8; ++c) kernel::add(n, g + (8 * d + c) * few, f.col(d).data() + row + corner[c]);
        }
}

double RealtimeEnergyModel::cubes_energy(const NodeColumns& u) const noexcept {
    constexpr int few = kernel::cubes_at_once;
    alignas(64) double g[24 * few], grown[few];
    double energy = 0;
    for (const Cubes::Run& run : cubes_.runs)
        for (int done = 0; done < run.count; done += few) {
            const int n = std::min(few, run.count - done);
            cubes_grown(run, done, n, u, g, grown);
            for (int k = 0; k < n; ++k) energy += cubes_.gain[static_cast<std::size_t>(run.first_slot + done + k)] * grown[k] * grown[k] / 2;
        }
    return energy;
}

/// Twice the change of a region's area [m2], summed over edges from terms in u, so that nothing cancels.
double RealtimeEnergyModel::twice_growth(const Region& region, const NodeColumns& u) const noexcept {
    double twice = 0;
    for (int k = region.begin; k < region.end; ++k) {
        const Step& step = walk_[static_cast<std::size_t>(k)];
        twice += u(step.node, 0) * (step.y + u(step.after, 1)) - u(step.node, 1) * (step.x + u(step.after, 0));
    }
    return twice;
}

void RealtimeEnergyModel::squares_force(const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept {
    alignas(64) double g[4 * chunk], grown[chunk], felt[chunk];
    double *gx = g, *gy = g + chunk, *hx = g + 2 * chunk, *hy = g + 3 * chunk;
    const Eigen::Index N = u.rows();
    for (int done = 0; done < squares_.count; done += chunk) {
        const int n = std::min(chunk, squares_.count - done), a = squares_.first + done;
        const double *ux = u.data() + a, *uy = ux + N;
        double *fx = f.data() + a, *fy = fx + N;
        const auto [b, c, d] = std::array{squares_.b, squares_.c, squares_.d};
        const double *px = squares_.px.data() + done, *py = squares_.py.data() + done, *qx = squares_.qx.data() + done, *qy = squares_.qy.data() + done,
                     *gain = squares_.gain.data() + done;
        if (memory) {
            kernel::squares_grown(n, px, py, qx, qy, ux, uy, ux + b, uy + b, ux + c, uy + c, ux + d, uy + d, gx, gy, hx, hy, grown);
            memory->step(first_square_ + done, n, grown, felt);
            kernel::times(n, gain, felt, 4, chunk, g);
        } else {
            kernel::squares(n, px, py, qx, qy, gain, ux, uy, ux + b, uy + b, ux + c, uy + c, ux + d, uy + d, gx, gy, hx, hy);
        }
        kernel::add_pair(n, gx, fx, fx + c);
        kernel::add_pair(n, gy, fy, fy + c);
        kernel::add_pair(n, hx, fx + b, fx + d);
        kernel::add_pair(n, hy, fy + b, fy + d);
    }
}

/// Sum over the elements of a BranchMemory: gain, or theta of a spring, times of_element(number in the memory).
template <class Of>
double RealtimeEnergyModel::sum_of_elements(const Of& of_element) const {
    double sum = 0;
    for (int slot : springs_.slot_of_spring()) sum += theta_[slot] * of_element(slot);
    for (int k = 0; k < squares_.count; ++k) sum += squares_.gain[static_cast<std::size_t>(k)] * of_element(first_square_ + k);
    for (std::size_t r = 0; r < regions_.size(); ++r) sum += regions_[r].gain * of_element(first_region_ + static_cast<int>(r));
    for (int k = 0; k < cubes_.count(); ++k) sum += cubes_.gain[static_cast<std::size_t>(k)] * of_element(first_cube_ + k);
    return sum;
}

Eigen::Vector3d RealtimeEnergyModel::Supports::moved(std::size_t m, const NodeColumns& u) const noexcept {
    const double *x = u.col(0).data(), *y = u.col(1).data(), *z = u.col(2).data();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int e = begin[m]; e < begin[m + 1]; ++e) {
        const double w = weight[static_cast<std::size_t>(e)];
        const int c = corner[static_cast<std::size_t>(e)];
        sum += w * Eigen::Vector3d(x[c], y[c], z[c]);
    }
    return sum;
}

double RealtimeEnergyModel::supports_energy(const NodeColumns& u) const noexcept {
    double energy = 0;
    for (std::size_t m = 0; m < supports_.gain.size(); ++m) energy += supports_.gain[m] * supports_.moved(m, u).squaredNorm() / 2;
    return energy;
}

void RealtimeEnergyModel::supports_force(const NodeColumns& u, NodeColumns& f) const noexcept {
    if (supports_.gain.empty()) return;
    double *x = f.col(0).data(), *y = f.col(1).data(), *z = f.col(2).data();
    for (std::size_t m = 0; m < supports_.gain.size(); ++m) {
        const Eigen::Vector3d moved = supports_.moved(m, u);
        for (int e = supports_.begin[m]; e < supports_.begin[m + 1]; ++e) {
            const double pull = supports_.gain[m] * supports_.weight[static_cast<std::size_t>(e)];
            const int c = supports_.corner[static_cast<std::size_t>(e)];
            x[c] += pull * moved.x();
            y[c] += pull * moved.y();
            z[c] += pull * moved.z();
        }
    }
}

double RealtimeEnergyModel::energy(const NodeColumns& u, BranchMemory memory) const {
    if (memory.empty()) return energy(u);
    NodeColumns f(u.rows(), u.cols());
    Scratch work = scratch();
    force(u, f, work, memory);
    return sum_of_elements([&](int element) { return memory.stored(element) / 2; }) + supports_energy(u);
}

BranchEnergies RealtimeEnergyModel::branches(const BranchMemory& memory) const {
    if (memory.empty() || !memory.booked()) return {};
    return {sum_of_elements([&](int element) { return memory.branches_stored(element); }), sum_of_elements([&](int element) { return memory.branches_dissipated(element); })};
}

double RealtimeEnergyModel::energy(const NodeColumns& u) const {
    double energy = springs_.potential_energy(theta_, u);
    for (int k = 0; k < squares_.count; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const int a = squares_.first + k;
        if (squares_.gain[i] == 0) continue;
        const Eigen::RowVector2d p = u.row(a + squares_.c) - u.row(a), q = u.row(a + squares_.d) - u.row(a + squares_.b);
        const double twice = squares_.px[i] * q.y() - squares_.py[i] * q.x() + p.x() * (squares_.qy[i] + q.y()) - p.y() * (squares_.qx[i] + q.x());
        energy += squares_.gain[i] * twice * twice / 2;
    }
    for (const Region& region : regions_) {
        const double twice = twice_growth(region, u);
        energy += region.gain * twice * twice / 2;
    }
    Scratch work = scratch();
    if (!springs_.rows().by_node()) springs_.rows().scatter(u, work.u);
    energy += cubes_energy(springs_.rows().by_node() ? u : work.u);
    energy += supports_energy(u);
    return energy;
}

}  // namespace tissue
