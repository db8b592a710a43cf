#include "eval/held_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "eval/force_table.h"
#include "eval/solid_force_table.h"
#include "mesh/free_surface.h"
#include "mesh/topology.h"
#include "parallel.h"
#include "springs/energy_model_terms.h"
#include "springs/heuristic.h"
#include "springs/indentation_solver.h"
#include "springs/set_grid.h"

namespace tissue {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;

/// A mesh and a spring force for baselines.
struct Setting {
    std::string suffix;
    SpringMesh mesh;
    std::unique_ptr<SpringLaw> law;
    double uniform_N_m;
};

/// A baseline: one theta [N/m] (S) for all contacts.
struct Baseline {
    std::string name;
    const Setting* setting;
    Eigen::VectorXd theta;
};

ContactReference reference_of(const SpringMesh& mesh, const LoadPath& path, const PathRecord& record) {
    return {mesh.is_solid() ? SurfacePoint{} : locate_on_surface(mesh, path.contact_m), path.push_m(record), record.contact_force_N,
            record.displacement};
}

/// The same lattice of nodes with springs of another topology.
SpringMesh with_topology(const SpringMesh& mesh, const std::string& topology) {
    if (!topologies().at(topology).needs_lattice()) return mesh;
    const Eigen::Vector2d size = (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).transpose();
    int cells_x = 0;
    while (cells_x + 1 < mesh.node_count() && mesh.nodes(cells_x + 1, 1) == mesh.nodes(0, 1)) ++cells_x;
    return make_lattice(topology, cells_x, mesh.node_count() / (cells_x + 1) - 1, size.x(), size.y());
}

std::vector<Setting> settings_of(const TissueModel& model, const std::vector<LoadCase>& loads, bool others) {
    std::vector<Setting> settings;
    const auto add = [&](const std::string& topology, const std::string& law) {
        const bool own = topology == model.mesh.topology && law == model.law;
        settings.push_back({own ? "" : "_" + topology + "_" + law, with_topology(model.mesh, topology),
                            make_spring_law(law), 0});
        // at most 150 of the training contacts are enough to choose one stiffness
        std::vector<ContactReference> references;
        const std::size_t stride = 1 + loads.size() / 150;
        for (std::size_t c = 0; c < loads.size(); c += stride)
            references.push_back(reference_of(settings.back().mesh, *loads[c].path, *loads[c].record));
        settings.back().uniform_N_m =
            best_uniform_stiffness(settings.back().mesh, *settings.back().law, references, 0.05 * model.modulus_N_m,
                                   40 * model.modulus_N_m)
                .value_or(model.modulus_N_m);
    };
    add(model.mesh.topology, model.law);
    if (!others) return settings;
    using Kinds = std::vector<std::pair<std::string, std::string>>;
    const Kinds kinds = !on_lattice(model.mesh) ? Kinds{{"edges", "isotropic"}, {"edges", "axial"}, {"edges", "geometric"}}
                                    : Kinds{{"grid4", "isotropic"}, {"grid8", "axial"}, {"grid8", "geometric"}};
    for (const auto& [topology, law] : kinds)
        if (topology != model.mesh.topology || law != model.law) add(topology, law);
    return settings;
}

std::vector<Baseline> baselines_of(const TissueModel& model, const std::vector<Setting>& settings, bool others) {
    std::vector<Baseline> baselines;
    if (!model.energy_model) baselines.push_back({"one_set", &settings[0], model.one_set});
    const double ratio_b = model.heuristic_b.sum() / model.heuristic_a.sum();
    for (const Setting& s : settings) {
        if (!others) break;
        // With springs on edges (no lattice) the model's heuristics hold for every spring force and include regions.
        const bool edges = !on_lattice(s.mesh);
        baselines.push_back({"heuristic_a" + s.suffix, &s, edges ? model.heuristic_a : heuristic_stiffness(s.mesh, model.modulus_N_m)});
        baselines.push_back({"heuristic_b" + s.suffix, &s, edges ? model.heuristic_b : heuristic_stiffness(s.mesh, ratio_b * model.modulus_N_m)});
        baselines.push_back({"uniform" + s.suffix, &s, uniform_stiffness(s.mesh, s.uniform_N_m)});
    }
    return baselines;
}

/// An energy model with other constants and the untrained contact, for the same disc radii. Its springs are linear, as
/// Van Gelder's heuristic assumes.
EnergyModel untrained_energy_model(const TrainedModel& model, const Eigen::VectorXd& constants, bool incompressible) {
    const EnergyModel& energy_model = *model.energy_model;
    EnergyModel other{{}, {}, constants, model.books.energy_model->untrained_patch, incompressible, energy_model.disc_radius_m, energy_model.disc};
    other.sizes = energy_model.sizes;
    return other;
}

/// In space: uniform stiffness [N/m] with the smallest median indentation error of force at some ten load cases, under
/// the untrained contact. Candidates are 0.25 to 4 times the mean of heuristic_a, in factors of sqrt(2).
double best_uniform_under_patch(const TrainedModel& model, const std::vector<LoadCase>& loads, int threads) {
    const double mean = model.heuristic_a.mean();
    const EnergyModelDiagnostics& diagnostics = *model.books.energy_model;
    double best = mean, best_median = std::numeric_limits<double>::infinity();
    std::vector<const LoadCase*> some;
    for (std::size_t c = 0; c < loads.size(); c += 1 + loads.size() / 10)
        if (loads[c].record->contact_force_N.squaredNorm() > 0) some.push_back(&loads[c]);
    for (double factor = 0.25; factor < 4.1; factor *= std::sqrt(2.0)) {
        const Eigen::VectorXd constants = springs_alone(model.mesh, diagnostics.untrained_constants, uniform_stiffness(model.mesh, factor * mean));
        const IndentationSolver solver(model.mesh, untrained_energy_model(model, constants, false));
        std::vector<double> errors(some.size(), std::numeric_limits<double>::infinity());
        parallel_for(static_cast<int>(some.size()), threads, [&](int i) {
            const LoadCase& load = *some[static_cast<std::size_t>(i)];
            const ContactAnswer answer = answer_of(solver, load.path->contact_m, load.path->push_m(*load.record), load.path->radius_m);
            const Point& force_N = load.record->contact_force_N;
            if (answer.force_N) errors[static_cast<std::size_t>(i)] = (Point(*answer.force_N) - force_N).norm() / force_N.norm();
        });
        const double median = statistics_of(errors).median;
        if (median < best_median) {
            best_median = median;
            best = factor * mean;
        }
    }
    return best;
}

/// Contact force along the tool displacement [N]; NaN without an equilibrium.
double pushed_force(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta, const LoadPath& path,
                    double magnitude_m) {
    const Equilibrium state = solve_equilibrium(mesh, law, theta, locate_on_surface(mesh, path.contact_m),
                                                path.direction * magnitude_m);
    return state ? state.contact_force.dot(path.direction) : std::nan("");
}

/// (name, "median") and (name, "largest") of the held_out contacts by displacement error of the first model; of two
/// medians the smaller. A missing answer is an infinite error: there is no entry where the median is infinite, and the
/// largest is the largest finite error.
std::vector<std::pair<std::string, std::string>> shown_shapes(const HeldOut& held_out) {
    std::vector<std::pair<double, std::string>> errors;
    if (const DrawnContacts* role = held_out.role("held_out"))
        for (const DrawnContact& c : role->contacts) {
            const std::optional<double>& shape = c.error[0].shape;
            errors.emplace_back(shape && std::isfinite(*shape) ? *shape : std::numeric_limits<double>::infinity(), c.name);
        }
    std::sort(errors.begin(), errors.end());
    const auto answered = static_cast<std::size_t>(std::count_if(errors.begin(), errors.end(), [](const auto& e) { return std::isfinite(e.first); }));
    std::vector<std::pair<std::string, std::string>> shown;
    if (const std::size_t middle = (errors.size() - 1) / 2; middle < answered) shown.emplace_back(errors[middle].second, "median");
    if (answered > 0) shown.emplace_back(errors[answered - 1].second, "largest");
    return shown;
}

/// The load path that a check path repeats on the finer mesh; nullptr without one.
const LoadPath* repeated_by(const LoadPath& check, const Cases& cases) {
    constexpr double same_m = 1e-9, same_direction = 1e-9;
    for (const LoadPath& path : cases.paths)
        if (path.role != "check" && (path.contact_m - check.contact_m).norm() <= same_m &&
            (path.direction - check.direction).norm() <= same_direction && std::abs(path.depth_m - check.depth_m) <= same_m && path.radius_m == check.radius_m)
            return &path;
    return nullptr;
}

}  // namespace

DiscretisationCheck check_discretisation(const Cases& cases) {
    DiscretisationCheck check;
    std::vector<double> differences;  // NaN where one of the two forces is missing
    constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
    for (const LoadPath& fine : cases.paths) {
        if (fine.role != "check") continue;
        if (!fine.lost.empty()) check.lost.push_back(fine.name + ": " + fine.lost);
        const LoadPath* coarse = repeated_by(fine, cases);
        if (!coarse) {
            check.unmatched.push_back(fine.name + ": the study's mesh has no load path with its contact, direction and depth");
            differences.push_back(nothing);
            continue;
        }
        const std::vector<double> wanted = coarse->role == "train" ? load_magnitudes(cases, *coarse) : std::vector{coarse->depth_m};
        for (double magnitude_m : wanted) {
            const PathRecord *there = coarse->record_at(magnitude_m), *record = fine.record_at(magnitude_m);
            differences.push_back(there && record ? (there->contact_force_N - record->contact_force_N).norm() / record->contact_force_N.norm()
                                                  : nothing);
            if (there && record) continue;
            if (record || fine.lost.empty())  // a path that ends early on the finer mesh is in check.lost
                check.unmatched.push_back(fmt::format(
                    "{}: {} has no record at {:.4g} mm{}", fine.name, record ? coarse->name : "it", 1e3 * magnitude_m,
                    record && !coarse->lost.empty() ? ", " + coarse->lost : ""));
        }
    }
    check.difference = statistics_of(differences);
    return check;
}

std::vector<double> DrawnContacts::radii_m() const {
    std::set<double> radii_m(lost_radius_m.begin(), lost_radius_m.end());
    for (const DrawnContact& c : contacts) radii_m.insert(c.radius_m);
    if (radii_m.size() < 2) return {};
    return {radii_m.begin(), radii_m.end()};
}

DrawnContacts DrawnContacts::of_disc(double radius_m) const {
    DrawnContacts some{role, {}, {}};
    for (const DrawnContact& c : contacts)
        if (c.radius_m == radius_m) some.contacts.push_back(c);
    for (std::size_t k = 0; k < lost_radius_m.size(); ++k)
        if (lost_radius_m[k] == radius_m) some.lost.push_back(lost[k]);
    return some;
}

ContactStatistics DrawnContacts::statistics(std::size_t model) const {
    std::vector<ContactError> errors;
    for (const DrawnContact& c : contacts) errors.push_back(c.error[model]);
    return contact_statistics(errors, static_cast<int>(lost.size()));
}

const DrawnContacts* HeldOut::role(const std::string& name) const {
    for (const DrawnContacts& r : roles)
        if (r.role == name) return &r;
    return nullptr;
}

HeldOut evaluate_held_out(const TrainedModel& model, const Cases& cases, int threads, bool with_baselines) {
    HeldOut result;
    for (const LoadPath& path : cases.paths)
        // pairs of tools are evaluated in eval/two_tools.h
        if (path.role != "train" && path.role != "check" && path.role != "map" && !path.second && !result.role(path.role))
            result.roles.push_back({path.role, {}, {}});
    if (result.empty()) return result;

    const std::vector<LoadCase> loads = load_cases(cases);
    const bool solid = model.mesh.is_solid();
    const std::vector<int> compared = compared_nodes(model.mesh);
    const std::unique_ptr<SpringLaw> law = make_spring_law(model.law);
    // two dimensions only: arc length along the free surface, and baselines under a contact of two nodes
    std::optional<Outline> outline;
    std::optional<ForceTable> table;
    std::optional<SolidForceTable> solid_table;
    std::vector<Setting> settings;
    std::vector<Baseline> baselines;
    const double disc_m = model.energy_model ? model.energy_model->disc_radius_m : 0;
    const auto disc_of = [&](const LoadPath& path) { return path.radius_m > 0 ? path.radius_m : disc_m; };
    if (solid) {
        solid_table.emplace(table_pushes(loads, symmetries_of(model), disc_m));
    } else {
        outline.emplace(model.mesh);
        table.emplace(*outline, table_pushes(loads, symmetries_of(model)));
        settings = settings_of(model, loads, with_baselines);
        baselines = baselines_of(model, settings, with_baselines);
    }

    // energy models, the trained one first
    std::vector<std::pair<std::string, std::unique_ptr<IndentationSolver>>> laws;
    std::optional<SetGrid> sets;
    if (model.energy_model) {
        laws.emplace_back("learned", std::make_unique<IndentationSolver>(model.mesh, energy_model_of_cases(model)));
        const EnergyModelDiagnostics& diagnostics = *model.books.energy_model;
        const auto add = [&](const std::string& name, const Eigen::VectorXd& constants, const SpringCurve& curve) {
            EnergyModel other = untrained_energy_model(model, constants, model.energy_model->incompressible);
            other.curve = curve;
            laws.emplace_back(name, std::make_unique<IndentationSolver>(model.mesh, std::move(other)));
        };
        add("untrained", diagnostics.untrained_constants, model.energy_model->curve);
        const auto add_springs = [&](const std::string& name, const Eigen::VectorXd& theta) { add(name, springs_alone(model.mesh, diagnostics.untrained_constants, theta), SpringCurve()); };
        if (with_baselines)
            for (const Baseline& b : baselines)
                if (b.setting == &settings[0]) add_springs(b.name + "_patch", b.theta);
        if (with_baselines && solid) {
            add_springs("heuristic_a_patch", model.heuristic_a);
            add_springs("uniform_patch", uniform_stiffness(model.mesh, best_uniform_under_patch(model, loads, threads)));
        }
    } else {
        sets.emplace(model);
    }
    const FreeSurface surface(model.mesh);
    result.models = {"learned", "force_table"};
    for (std::size_t l = 1; l < laws.size(); ++l) result.models.push_back(laws[l].first);
    for (const Baseline& b : baselines) result.models.push_back(b.name);
    if (cases.measurement) result.models.push_back("repeat");

    const auto learned = [&](const LoadPath& path, const PathRecord& record) {
        if (!sets) return answer_of(*laws[0].second, path.contact_m, path.push_m(record), path.radius_m);
        const int set = sets->nearest(outline->arc_of(path.contact_m), path.direction, record.magnitude_m);
        return answer_of(model.mesh, *law, model.trained.front().theta.row(set).transpose(), reference_of(model.mesh, path, record));
    };
    for (DrawnContacts& role : result.roles) {
        std::vector<const LoadPath*> paths;
        for (const LoadPath& path : cases.paths) {
            if (path.role != role.role) continue;
            if (path.lost.empty()) {
                paths.push_back(&path);
                continue;
            }
            role.lost.push_back(path.name + ": " + path.lost);
            if (solid) role.lost_radius_m.push_back(disc_of(path));
        }
        role.contacts.resize(paths.size());
        parallel_for(static_cast<int>(paths.size()), threads, [&](int p) {
            const LoadPath& path = *paths[static_cast<std::size_t>(p)];
            const PathRecord& record = path.records.back();
            const double arc = solid ? std::nan("") : outline->arc_of(path.contact_m);
            const double times = solid && disc_m > 0 ? disc_of(path) / disc_m : 1;
            ForceTable::Entry tabled = solid ? solid_table->at(path.contact_m, path.direction, record.magnitude_m / times)
                                             : table->at(arc, path.direction, record.magnitude_m);
            tabled.force_N *= times * times;
            const ContactReference reference = reference_of(model.mesh, path, record);
            DrawnContact& contact = role.contacts[static_cast<std::size_t>(p)];
            const FreeSurface::Place place = solid ? surface.nearest(path.contact_m) : FreeSurface::Place{};
            const double angle = solid ? std::acos(std::clamp(place.inward.dot(path.direction), -1.0, 1.0)) : outline->angle(arc, path.direction);
            contact = {path.name, path.contact_m, path.direction, arc, angle / degree, record.magnitude_m, solid ? surface.clearance_m(path.contact_m) : std::nan(""),
                       solid ? surface.thickness_m(place.point_m, place.inward) : std::nan(""), record.contact_force_N, tabled.extrapolated, {}, solid ? disc_of(path) : 0};
            const auto add = [&](const ContactAnswer& answer) {
                contact.error.push_back(error_of(answer, reference, model.mesh, compared));
            };
            add(learned(path, record));
            add({tabled.force_N});
            for (std::size_t l = 1; l < laws.size(); ++l) add(answer_of(*laws[l].second, path.contact_m, reference.push_m, path.radius_m));
            for (const Baseline& b : baselines) add(answer_of(b.setting->mesh, *b.setting->law, b.theta, reference));
            if (cases.measurement && path.again_N) add({*path.again_N});
            if (cases.measurement && !path.again_N) contact.error.push_back({{}, {}, {}, "measured once"});
        });
    }

    constexpr std::size_t shown = 6;
    for (const LoadPath& path : cases.paths) {
        if (cases.measurement) break;  // measured load cases are single indentations
        if (path.role != "held_out" || !path.lost.empty() || result.curves.size() == shown) continue;
        DrawnCurve curve{path.name, {}, {}, {}, {}};
        for (const PathRecord& record : path.records) {
            const double m = record.magnitude_m;
            curve.magnitude_m.push_back(m);
            curve.fe_N.push_back(record.contact_force_N.dot(path.direction));
            const ContactAnswer answer = m > 0 ? learned(path, record) : ContactAnswer{};
            curve.learned_N.push_back(m > 0 ? answer.force_N ? answer.force_N->dot(path.direction) : std::nan("") : 0);
            if (solid && with_baselines) {
                const ContactAnswer uniform = m > 0 ? answer_of(*laws.back().second, path.contact_m, path.push_m(record), path.radius_m) : ContactAnswer{};
                curve.uniform_N.push_back(m > 0 ? uniform.force_N ? uniform.force_N->dot(path.direction) : std::nan("") : 0);
                continue;
            }
            curve.uniform_N.push_back(
                solid   ? std::nan("")
                : m > 0 ? pushed_force(settings[0].mesh, *law, uniform_stiffness(model.mesh, settings[0].uniform_N_m), path, m)
                        : 0);
        }
        result.curves.push_back(std::move(curve));
    }
    for (const auto& [name, which] : shown_shapes(result)) {
        const auto path = std::find_if(cases.paths.begin(), cases.paths.end(),
                                       [&, name = name](const LoadPath& p) { return p.name == name; });
        const PathRecord& record = path->records.back();
        result.shapes.push_back({name, which, learned(*path, record).displacement_m.topRows(cases.nodes.rows())});
    }
    return result;
}

}  // namespace tissue
