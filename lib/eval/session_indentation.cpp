#include "eval/session_indentation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/virtual_device.h"
#include "mesh/free_surface.h"
#include "mesh/outline.h"
#include "springs/equilibrium.h"
#include "springs/indentation_solver.h"

namespace tissue {
namespace {

/// Static equilibrium of the model: of the energy model, or of springs with a given theta.
class StaticAnswer {
   public:
    explicit StaticAnswer(const TissueModel& tissue) : tissue_(tissue), spring_law_(make_spring_law(tissue.law)) {
        if (tissue.energy_model) law_.emplace(tissue);
    }

    Equilibrium at(const Point& contact_m, const Point& push_m, const Eigen::VectorXd& theta) const {
        return law_ ? law_->at(contact_m, push_m)
                    : solve_equilibrium(tissue_.mesh, *spring_law_, theta, locate_on_surface(tissue_.mesh, contact_m), push_m);
    }

   private:
    const TissueModel& tissue_;
    std::unique_ptr<SpringLaw> spring_law_;
    std::optional<IndentationSolver> law_;
};

/// Unit normal into the tissue. At a corner in two dimensions it is the mean of both sides, as in the paper.
Point inward_at(const SpringMesh& mesh, const Point& contact_m) {
    if (mesh.is_solid()) return FreeSurface(mesh).nearest(contact_m).inward;
    const Outline outline(mesh);
    return outline.inward_normal(outline.arc_of(contact_m));
}

/// Stiffness in use [N/m], in the order of the mesh's springs (S).
Eigen::VectorXd theta_in_use(const RealtimeMesh& mesh, const MeshState& state) {
    Eigen::VectorXd theta(mesh.spring_count());
    for (int s = 0; s < mesh.spring_count(); ++s) theta[s] = state.theta[mesh.slot_of_spring()[static_cast<std::size_t>(s)]];
    return theta;
}

}  // namespace

IndentationResult indent(const HapticModel& model, const TissueModel& tissue, const IndentationReference& reference, double seconds_max) {
    constexpr double inset_m = 0.0003;    // so that a tangential displacement stays inside until the hand is corrected
    constexpr double same_contact_m = 5e-4;  // a tenth of the half width of the FE indenter's patch
    constexpr double ramp_s = 2, window_s = 0.5, settled = 1e-4;
    // Gain of the hand's correction. Through the virtual coupling it must be slower than the decay of the mesh's
    // vibration, or the correction would excite it. The tool of an energy model follows the hand without a coupling.
    const double creep_1_s = model.is_energy_model() ? 10 : 0.3;
    IndentationResult result;
    result.name = reference.name;
    result.fe_asked = reference.force_N.has_value();
    result.displacement_m = result.force_N = result.static_N = Point::Zero(tissue.mesh.dimension());
    const Point inward = inward_at(tissue.mesh, reference.contact_m);
    const double dt = model.options.dt_s;

    Simulation simulation(model);
    const Point target = reference.magnitude_m * reference.direction;
    const Point aim = model.is_energy_model() ? Point(target - inset_m * inward) : Point((1 + 1 / *model.options.coupling_ratio) * target);
    VirtualDevice hand(indentation_motion(reference.contact_m, inward, aim, ramp_s, inset_m), model.options.map);
    const bool pulls = reference.direction.dot(inward) < -1e-9;
    Point shift = Point::Zero(target.size()), last = shift;
    int still = 0;
    const int window = static_cast<int>(window_s / dt), sample = std::max(1, static_cast<int>(0.01 / dt));
    for (int k = 0; k * dt < seconds_max && !result.rested; ++k) {
        DeviceSample at = hand.read(k * dt);
        at.position_m += model.options.map.to_device(shift + model.options.map.offset_m);
        at.grasp = pulls && (simulation.contact().pressing || simulation.grasps());  // a tool that pulls grasps first
        simulation.tick(at);
        const TickRecord& r = simulation.record();
        // after the ramp: correct the hand until the proxy has the target displacement
        if (k * dt > ramp_s && r.mesh == 0) {
            shift += creep_1_s * dt * (target - r.contact_displacement_m);
        }
        if (k % sample == 0) {
            result.time_s.push_back(k * dt);
            result.depth_m.push_back(r.mesh == 0 ? r.contact_displacement_m.dot(reference.direction) : 0);
            result.curve_N.push_back(-r.coupling_N.dot(reference.direction));
        }
        if (k % window == window - 1) {
            still = k * dt > ramp_s + window_s && r.mesh == 0 &&
                            (r.coupling_N - last).norm() < settled * r.coupling_N.norm()
                        ? still + 1
                        : 0;
            result.rested = still == 2;
            last = r.coupling_N;
        }
        result.seconds = (k + 1) * dt;
    }
    const TickRecord& r = simulation.record();
    result.energy_given_J = simulation.safety().counters().energy_given_J;
    result.displacement_m = r.contact_displacement_m;
    result.force_N = -r.coupling_N;
    if (r.set >= 0) result.set = model.set_names[static_cast<std::size_t>(r.set)];
    if (r.mesh != 0) {
        result.reason = simulation.counters().unstable > 0 ? "the mesh diverged" : pulls && !model.grasps() ? "the case pulls, and the model cannot grasp" : "the tool lost contact";
        return result;
    }

    const RealtimeMesh& springs = model.meshes[0]->springs;
    const Point touched = springs.rest_place(r.facet, r.weight);
    const StaticAnswer answer(tissue);
    const Eigen::VectorXd theta = theta_in_use(springs, simulation.state(0));
    const auto rest = answer.at(touched, result.displacement_m, theta);
    result.reason = reason_of(rest.status);
    if (!rest) return result;
    result.static_N = rest.contact_force;
    result.static_error = (result.force_N - result.static_N).norm() / result.static_N.norm();
    // the FE force holds for its own contact only, not where the tool slipped to another one
    result.off_contact_m = (touched - reference.contact_m).norm();
    if (reference.force_N) {
        if (result.off_contact_m < same_contact_m) result.fe_error = (result.force_N - *reference.force_N).norm() / reference.force_N->norm();
        const auto exact = answer.at(reference.contact_m, reference.magnitude_m * reference.direction, theta);
        result.static_fe_error = exact ? (exact.contact_force - *reference.force_N).norm() / reference.force_N->norm() : std::numeric_limits<double>::infinity();
    }
    return result;
}

SwitchJump switch_jump(const TissueModel& tissue, HapticOptions options, int from, int to, double innovation) {
    // The dynamics step is called directly, without the simulation's safety limits.
    options.innovation = innovation;
    SwitchJump jump;
    jump.innovation = innovation;
    jump.from = tissue.case_names[static_cast<std::size_t>(from)];
    jump.to = tissue.case_names[static_cast<std::size_t>(to)];
    const HapticModel model(tissue, options);
    const HapticMesh& mesh = *model.meshes[0];
    const Eigen::Vector2d contact = tissue.contact_m.row(from), direction = tissue.direction.row(from);
    const SurfacePoint point = locate_on_surface(tissue.mesh, contact);
    MeshState state(mesh.springs, mesh.theta_of_set.col(from));
    const auto dynamics = make_dynamics(mesh.dynamics, mesh.springs, {options.dt_s, mesh.damping_1_s});
    ContactLoad load;
    for (int end : {0, 1}) {
        load.node[end] = point.node[end];
        load.weight[end] = point.weight[end];
    }
    const std::vector<int> loop = tissue.mesh.loop();
    const auto segment = static_cast<int>(
        std::find(loop.begin(), loop.end(), point.node[0]) - loop.begin());
    load.coupling_N_m = *model.options.coupling_ratio * model.stiffness->at(segment, point.weight[1]);
    load.master_m = contact + tissue.magnitude_m[from] * direction;

    // 20 s of simulated time with the first set bring the mesh to rest
    Point force = Point::Zero(2);
    for (int k = 0; k < static_cast<int>(20 / options.dt_s); ++k) force = dynamics->step(state, load);

    const Eigen::VectorXd target = mesh.theta_of_set.col(to);
    const double before = mesh.springs.potential_energy(state.theta, state.displacement);
    jump.energy_bound_J = innovation * std::abs(mesh.springs.potential_energy(target, state.displacement) - before);
    double last_force = force.dot(direction);
    jump.time_s.push_back(0);
    jump.force_N.push_back(last_force);
    jump.energy_J.push_back(before);
    for (int k = 1; k <= static_cast<int>(0.5 / options.dt_s); ++k) {
        const double was = mesh.springs.potential_energy(state.theta, state.displacement);
        state.theta += innovation * (target - state.theta);
        state.theta_changed = true;
        const double now = mesh.springs.potential_energy(state.theta, state.displacement);
        if (std::abs(now - was) > jump.energy_jump_J) jump.energy_jump_J = std::abs(now - was);
        force = dynamics->step(state, load);
        jump.force_jump_N = std::max(jump.force_jump_N, std::abs(force.dot(direction) - last_force));
        last_force = force.dot(direction);
        jump.time_s.push_back(k * options.dt_s);
        jump.force_N.push_back(last_force);
        jump.energy_J.push_back(mesh.springs.potential_energy(state.theta, state.displacement));
    }
    return jump;
}

}  // namespace tissue
