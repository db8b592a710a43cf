#include "haptic/simulation.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "error.h"
#include "haptic/dynamics_kinds.h"
#include "haptic/energy_model_spectrum.h"
#include "haptic/session_options.h"
#include "haptic/spectrum.h"
#include "haptic/support_mass.h"
#include "springs/energy_model_at_radius.h"
#include "springs/energy_model_terms.h"
#include "springs/spring_sets.h"
#include "version.h"

namespace tissue {
namespace {

constexpr double elastic_damping_ratio = 0.17, relaxing_damping_ratio = 0.01;
constexpr double usual_innovation = 0.05, usual_coupling_ratio = 10;
constexpr double turn = 2 * 3.14159265358979323846;

/// Makes a mesh of springs. law: the name of a SpringLaw, or the curve of springs along their current direction.
/// theta: one spring set a row [N/m] (C x S).
template <class Law>
std::unique_ptr<HapticMesh> make_mesh(const std::string& name, const TissueModel& model, const Law& law,
                                      const Eigen::Ref<const NodeField>& theta, const Point& place_m, const Eigen::VectorXd& node_mass_kg) {
    if (!theta.allFinite() || !(theta.minCoeff() > 0))
        throw MismatchError(fmt::format("the {} mesh has spring stiffnesses that are not positive", name));
    auto mesh = std::make_unique<HapticMesh>(
        HapticMesh{name, RealtimeMesh(model.mesh, law, node_mass_kg), {}, nullptr, place_m, "", 1, 0, 0, 0, 0, 0, 0, 0});
    mesh->theta_of_set.resize(mesh->springs.slot_count(), theta.rows());
    for (Eigen::Index c = 0; c < theta.rows(); ++c) mesh->theta_of_set.col(c) = mesh->springs.to_slots(theta.row(c).transpose());
    return mesh;
}

double ball_m(const ToolChoice& tool) { return tool.shape == ToolChoice::Shape::ball ? tool.radius_m : 0; }

/// Makes a mesh of an energy model. tool: the first of the session.
std::unique_ptr<HapticMesh> make_energy_model_mesh(const std::string& name, const TissueModel& model, const Point& place_m, const ToolChoice& tool) {
    const NodeField theta = model.energy_model->constants.head(model.mesh.spring_count()).transpose();
    auto mesh = make_mesh(name, model, model.energy_model->curve, theta, place_m, mass_with_supports(model));
    mesh->energy_model = std::make_unique<RealtimeEnergyModel>(model, mesh->springs, ball_m(tool));
    return mesh;
}

/// The baseline in space: Van Gelder's springs without cells, with the contact of the trained energy model. A point
/// load on a 3-D lattice has no stiffness of its own, so springs under a virtual coupling would be no baseline (in the
/// plane they are).
TissueModel untrained(const TissueModel& model) {
    TissueModel heuristic = model;
    Eigen::VectorXd& constants = heuristic.energy_model->constants;
    constants = springs_alone(model.mesh, constants, model.heuristic_a);
    heuristic.energy_model->curve = SpringCurve();
    heuristic.energy_model->terms.clear();  // the baseline has no trained part, and no trained skin
    heuristic.energy_model->coefficients.resize(0);
    return heuristic;
}

/// HapticMesh::lead [dt]. The tool moves on a straight line through the n steps of a tick, so their mean force is that
/// at (n - 1) / 2n of dt after its start. The contact's damper adds its own time ahead.
double lead_of(const HapticMesh& mesh, double dt_s) {
    return (mesh.substeps - 1) / (2.0 * mesh.substeps) + mesh.contact_damping_s / dt_s;
}

/// Chooses the time integration of an energy model and its damping, from the spectrum of the instantaneous stiffness.
/// of_tool: the model with each tool, or with the one of all tools.
void choose_energy_model_dynamics(const std::vector<TissueModel>& of_tool, const ToolChoices& tools, HapticMesh& mesh, const HapticOptions& o) {
    EnergyModelSpectrum spectrum{};
    for (std::size_t k = 0; k < of_tool.size(); ++k) {
        const EnergyModelSpectrum own = energy_model_spectrum(of_tool[k], mesh.springs, o.tools);
        // A ball's force is 5/4 of the disc's, and grows as d^1.5 (Hertz). Its contact is larger on a concave surface.
        const double stiffer = tools[k].shape == ToolChoice::Shape::ball ? 1.5 * 1.25 * BallContact::hollow : 1;
        spectrum.smallest = own.smallest;  // of the tissue alone
        if (!(own.largest <= spectrum.largest) && !std::isnan(spectrum.largest)) spectrum.largest = own.largest;  // std::max would drop NaN
        spectrum.contact_N_m = std::max(spectrum.contact_N_m, stiffer * own.contact_N_m);
        spectrum.static_N_m = std::max(spectrum.static_N_m, stiffer * own.static_N_m);
    }
    const double lowest = std::sqrt(spectrum.smallest);
    mesh.largest_eigenvalue_1_s2 = spectrum.largest;
    mesh.contact_N_m = o.stiffest * spectrum.contact_N_m;
    mesh.static_N_m = o.stiffest * spectrum.static_N_m;
    mesh.dynamics = o.dynamics == "auto" ? "symplectic" : o.dynamics;
    mesh.substeps = energy_model_substeps(o.stiffest * spectrum.largest, o.dt_s);
    mesh.lowest_frequency_Hz = lowest / turn;
    mesh.damping_1_s = 2 * *o.damping_ratio * lowest;
    mesh.contact_damping_s = energy_model_contact_damping_s(o.stiffest * spectrum.largest, o.dt_s, mesh.substeps);
    mesh.lead = lead_of(mesh, o.dt_s);
    // made to check the options: it throws where they do not fit
    make_dynamics(mesh.dynamics, mesh.springs, {o.dt_s / mesh.substeps, mesh.damping_1_s, mesh.energy_model.get()});
}

/// The same for spring sets. coupling_N_m: k_C at the stiffest place of the outline.
void choose_dynamics(HapticMesh& mesh, const HapticOptions& o, double damping_ratio, double coupling_N_m) {
    double bare = 0;
    for (Eigen::Index c = 0; c < mesh.theta_of_set.cols(); ++c) {
        const double here = largest_eigenvalue(mesh.springs, mesh.theta_of_set.col(c));
        if (here > bare || std::isnan(here)) bare = here;  // std::max would drop NaN
    }
    double lightest = 0;
    for (int node : mesh.springs.outline()) lightest = std::max(lightest, mesh.springs.inverse_mass()[node]);
    mesh.largest_eigenvalue_1_s2 = bare + coupling_N_m * lightest;
    mesh.contact_N_m = coupling_N_m;
    mesh.static_N_m = coupling_N_m / *o.coupling_ratio;
    mesh.dynamics = o.dynamics == "auto" ? stable_dynamics(mesh.largest_eigenvalue_1_s2, o.dt_s) : o.dynamics;
    mesh.contact_damping_s = mesh.dynamics == paper_dynamics.name ? 0 : contact_damping_s(o.dt_s, 1);
    if (mesh.dynamics == symplectic_dynamics.name) {
        // As many steps h as the contact's damper needs: omega^2 + (2 ahead / h) (coupling / mass) <= (1.8 / h)^2.
        constexpr int most_steps = 1000;  // as in energy_model_substeps()
        const auto stable = [&](int steps) {
            const double h = o.dt_s / steps;
            return mesh.largest_eigenvalue_1_s2 + 2 * contact_damping_s(o.dt_s, steps) / h * coupling_N_m * lightest <= std::pow(symplectic_dynamics.stable_omega_dt / h, 2);
        };
        for (mesh.substeps = 1; !stable(mesh.substeps); ++mesh.substeps)
            if (mesh.substeps == most_steps)
                throw MismatchError(fmt::format("the {} mesh needs more than {} symplectic steps in {:g} ms: it is too stiff for its mass", mesh.name, most_steps, 1e3 * o.dt_s));
        mesh.contact_damping_s = contact_damping_s(o.dt_s, mesh.substeps);
    }
    mesh.lead = lead_of(mesh, o.dt_s);
    const Eigen::VectorXd mean = mesh.theta_of_set.rowwise().mean();
    const double lowest = std::sqrt(smallest_eigenvalue(mesh.springs, mean));
    mesh.lowest_frequency_Hz = lowest / turn;
    // A mesh with zero-energy modes has no lowest frequency: a hundredth of its highest is taken instead.
    mesh.damping_1_s = 2 * damping_ratio * (lowest > 0 ? lowest : 0.01 * std::sqrt(bare));
}

}  // namespace

void check_device(const DeviceImpedance& device, const DeviceMap& map, double dt_s, const HapticMesh& mesh) {
    if (!(device.mass_kg > 0) && (device.damping_Ns_m > 0 || std::isfinite(device.rate_Hz)))
        throw MismatchError("device-damping and device-rate have no effect without device-mass: set device-mass first");
    const double scale = map.force_scale * map.scale;
    const auto refuse = [&](double tissue_N_m, const char* when, double limit_N_m, auto whose) {
        const double most = map.force_scale * limit_N_m / (scale * tissue_N_m);
        if (!(most >= map.force_scale))
            throw MismatchError(fmt::format("the stiffness of the {} mesh at the device is up to {:.0f} N/m {}, at force-scale {:g}; {} {:.0f} N/m: {}", mesh.name, scale * tissue_N_m, when, map.force_scale, whose(),
                                            limit_N_m, most >= 0.01 ? fmt::format("set force-scale to at most {:.2f}", std::floor(100 * most) / 100) : "no force-scale is small enough"));
    };
    refuse(mesh.static_N_m, "at rest", device.stiffness_N_m, [] { return std::string("the device can render at most"); });
    const double period_s = std::max(dt_s, 1 / device.rate_Hz);
    if (device.mass_kg > 0)
        refuse(mesh.contact_N_m, "instantaneously", stable_stiffness_N_m(device, period_s, mesh.lead * dt_s / period_s),
               [&] { return fmt::format("a device of {:g} kg and {:g} Ns/m, with a force every {:g} s{}, is stable in any hand up to", device.mass_kg, device.damping_Ns_m, period_s,
                                       device.delay_s > 0 ? fmt::format(" and {:g} s late", device.delay_s) : ""); });
}

void check_options(const HapticOptions& o) {
    for (const SessionOption& option : session_options()) option.check(o);
    if (!(o.dt_s <= o.safety.hold_s / 2)) throw MismatchError(fmt::format("dt must be at most half of hold, {:g} s, not {:g}: the device may release a force before the next one", o.safety.hold_s / 2, o.dt_s));
    if (o.tool.size() != 1 && static_cast<int>(o.tool.size()) != o.tools)
        throw MismatchError(fmt::format("tool names {} tools, and tools is {}: name one for all or one for each", o.tool.size(), o.tools));
    Friction{o.friction};  // throws where static and kinetic friction contradict each other
    if (!(o.stiffest >= 1)) throw MismatchError("the largest factor of an adapted stiffness must be at least 1");
    if (!(o.safety.damping_max_Ns_m >= 0)) throw MismatchError("the largest damping of the passivity controller must not be negative");
    if (!std::isfinite(o.place_m)) throw MismatchError("the position of the second mesh must be finite");
}

namespace {

std::uint64_t fingerprint_of(const HapticModel& model, const std::vector<TissueModel>& of_tool) {
    XXH3_state_t* const hash = XXH3_createState();
    if (!hash) throw std::bad_alloc();
    XXH3_64bits_reset(hash);
    const auto add = [&](const void* data, std::size_t bytes) { XXH3_64bits_update(hash, data, bytes); };
    const auto add_array = [&](const auto& values) { add(values.data(), sizeof(*values.data()) * static_cast<std::size_t>(values.size())); };
    add_array(std::string(version));
    const double numbers[] = {model.options.dt_s, model.options.safety.stale_s, model.options.safety.damping_max_Ns_m, *model.options.innovation, static_cast<double>(model.options.select_by), model.options.safety.hold_s, model.options.safety.force_max_N, model.options.safety.slew_N_s, model.options.safety.speed_max_m_s, model.options.stiffest,
                              static_cast<double>(model.options.safety.passivity), static_cast<double>(model.options.energy_book), static_cast<double>(model.options.tools)};
    add(numbers, sizeof numbers);
    for (const auto& mesh : model.meshes) {
        add_array(mesh->springs.rest());
        add_array(mesh->springs.mass());
        add_array(mesh->springs.facets());
        add_array(mesh->theta_of_set);
        const Embedding& embedding = mesh->springs.embedding();
        add_array(embedding.corner);
        add_array(embedding.weight);
        add_array(embedding.cubes);
        add_array(embedding.fraction);
        add_array(embedding.centroid);
        const double steps[] = {static_cast<double>(mesh->substeps), mesh->contact_damping_s, mesh->damping_1_s, mesh->contact_N_m, mesh->place_m[0]};
        add(steps, sizeof steps);
        add_array(mesh->dynamics);
        add_array(mesh->springs.law().name());
        if (const SpringCurve* curve = mesh->springs.law().curve()) {
            const double of_curve[] = {curve->q(), curve->shorter().stretch, curve->longer().stretch};
            add(of_curve, sizeof of_curve);
        }
        if (!mesh->energy_model) continue;
        add_array(mesh->energy_model->stiffness().constants);
        add_array(mesh->energy_model->stiffness().patch.log_N_m);
        add_array(mesh->energy_model->relaxation().tau_s);
        add_array(mesh->energy_model->relaxation().share);
        add_array(mesh->energy_model->relaxation().contact_share);
    }
    for (std::size_t k = 0; k < of_tool.size(); ++k) {  // what contacts depend on besides patch.log_N_m of the first tool
        const TissueModel& tissue = of_tool[k];
        if (!tissue.energy_model) continue;
        add_array(tissue.energy_model->disc.ground);
        add_array(tissue.energy_model->disc.curved_range);
        add_array(tissue.energy_model->disc.correction.value);
        const double radii_m[] = {tissue.energy_model->disc_radius_m, ball_m(model.tools[k])};
        add(radii_m, sizeof radii_m);
        add_array(tissue.energy_model->patch.log_N_m);
        for (const std::string& term : tissue.energy_model->terms) add_array(term);
        add_array(tissue.energy_model->coefficients);
        add_array(tissue.energy_model->disc.sizes.radii_m);
        for (const FacetTable& table : tissue.energy_model->disc.sizes.correction) add_array(table.value);
    }
    const std::uint64_t fingerprint = XXH3_64bits_digest(hash);
    XXH3_freeState(hash);
    return fingerprint;
}

}  // namespace

namespace {

/// The model with each tool of the options, or once where all tools are alike.
std::vector<TissueModel> with_tools(const TissueModel& model, const HapticOptions& o) {
    if (model.energy_model && model.energy_model->disc.ball_contact_m > 0) throw MismatchError("a model that with_tool() has prepared for a ball: give the model of the file, and the tool as an option");
    std::vector<TissueModel> of_tool;
    for (const ToolChoice& tool : o.tool) of_tool.push_back(with_tool(model, tool));
    if (of_tool.size() == 2 && o.tool[0] == o.tool[1]) of_tool.pop_back();
    return of_tool;
}

/// The tools of the session, with the radius of the model's own disc where none is given.
ToolChoices tools_of(const std::vector<TissueModel>& of_tool, const HapticOptions& o) {
    ToolChoices tools;
    for (int k = 0; k < o.tools; ++k) {
        const auto& energy_model = of_tool[std::min(static_cast<std::size_t>(k), of_tool.size() - 1)].energy_model;
        tools.push_back(choice_of(o.tool, static_cast<std::size_t>(k)));
        if (tools.back().radius_m == 0 && energy_model) tools.back().radius_m = energy_model->disc_radius_m;
    }
    return tools;
}

}  // namespace

void HapticModel::check_grasp(int tool) const {
    if (!grasps(tool)) throw MismatchError("this model cannot grasp: it has spring sets, or in space its tool is a ball or its contact was not trained to be pulled (term contact.compression)");
}

HapticModel::HapticModel(const TissueModel& model, const HapticOptions& given) : HapticModel((check_options(given), with_tools(model, given)), given) {}

HapticModel::HapticModel(const std::vector<TissueModel>& of_tool, const HapticOptions& given)
    : study(of_tool[0].study), tools(tools_of(of_tool, given)), options(given), set_names(of_tool[0].case_names), surface(of_tool[0].mesh), rest(of_tool[0].mesh) {
    const TissueModel& model = of_tool[0];
    if (model.mesh.is_solid() && !model.energy_model) throw MismatchError("a model in space must be an energy model; this one has spring sets");
    if (given.tools > 1 && (!model.energy_model || given.heuristic_mesh))
        throw MismatchError(!model.energy_model ? "two tools need an energy model, and this model has spring sets" : "two tools are not possible with the heuristic mesh: set heuristic to no");
    may_be_pulled = model.energy_model && (!model.mesh.is_solid() || model.energy_model->patch.curve == ContactCurve::compression);
    if (std::isfinite(given.grasp_max_N) && !(given.tools > 1 && grasps(1))) check_grasp();
    if (!model.mesh.nodes.allFinite()) throw MismatchError("positions of nodes must be finite");
    HapticOptions& o = options;
    const bool damping_asked = o.damping_ratio.has_value();
    if (!o.damping_ratio) o.damping_ratio = !model.energy_model ? 0.05 : model.energy_model->relaxation.empty() ? elastic_damping_ratio : relaxing_damping_ratio;
    if (!o.innovation) o.innovation = usual_innovation;
    if (!o.coupling_ratio) o.coupling_ratio = usual_coupling_ratio;
    o.map.fit(model.mesh.dimension());
    o.safety.dt_s = o.dt_s;
    o.safety.force_max_N = std::min(o.safety.force_max_N, o.device.force_max_N);
    low_m = model.mesh.own_nodes().colwise().minCoeff();
    high_m = model.mesh.own_nodes().colwise().maxCoeff();
    if (o.place_m == 0) o.place_m = 1.5 * (high_m - low_m).x();

    std::vector<int> first_set(static_cast<std::size_t>(model.mesh.facets.rows()), 0);  // heuristic mesh: one set
    if (model.energy_model) {
        if (!o.sets.empty()) throw MismatchError(fmt::format("spring sets '{}': an energy model has none", o.sets));
        if (o.select_by != SelectBy::displacement) throw MismatchError("select-by: an energy model has no spring sets to select by force");
        if (given.innovation) throw MismatchError("innovation: an energy model has no spring sets to average");
        set_names.clear();
        meshes.push_back(make_energy_model_mesh("learned", model, Point::Zero(dimension()), tools[0]));
        for (std::size_t k = 1; k < of_tool.size(); ++k) meshes[0]->energy_model->add_tool(model.mesh, *of_tool[k].energy_model, ball_m(tools[k]));
    } else {
        const NodeField& theta = sets_of(model, o.sets);
        if (o.sets.empty()) o.sets = model.trained.front().optimizer;
        selector = std::make_unique<Selector>(model, theta, o.select_by);
        for (std::size_t b = 0; b < first_set.size(); ++b) first_set[b] = selector->select(static_cast<int>(b), 0.5, Eigen::Vector2d::Zero());
        meshes.push_back(make_mesh("learned", model, model.law, theta, Eigen::Vector2d::Zero(), model.node_mass_kg));
    }
    Point beside = Point::Zero(dimension());
    beside[0] = o.place_m;
    if (o.heuristic_mesh && is_solid())
        meshes.push_back(make_energy_model_mesh("heuristic", untrained(model), beside, tools[0]));
    else if (o.heuristic_mesh)  // of the instantaneous E, since spring sets do not relax
        meshes.push_back(make_mesh("heuristic", model, model.law, model.heuristic_a.transpose(), beside, model.node_mass_kg));
    const auto springs = std::find_if(meshes.begin(), meshes.end(), [](const auto& mesh) { return !mesh->energy_model; });
    if (springs == meshes.end() && given.coupling_ratio) throw MismatchError("coupling: no mesh of this session has spring sets; leave the option out");
    if (o.energy_book && (!is_energy_model() || model.energy_model->relaxation.empty())) throw MismatchError("energy-book: the model does not relax and has no Maxwell branches");
    if (springs != meshes.end())
        stiffness = std::make_unique<ContactStiffness>((*springs)->springs, first_set, (*springs)->theta_of_set);
    for (auto& mesh : meshes) {
        if (mesh->energy_model)
            choose_energy_model_dynamics(mesh->name == "learned" ? of_tool : std::vector<TissueModel>{untrained(model)}, tools, *mesh, o);
        else
            choose_dynamics(*mesh, o, damping_asked || !model.energy_model ? *o.damping_ratio : elastic_damping_ratio, *o.coupling_ratio * stiffness->largest());
        check_device(o.device, o.map, o.dt_s, *mesh);
    }
    fingerprint = fingerprint_of(*this, of_tool);
}

}  // namespace tissue
