#include "cases/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "cases/history_plan.h"
#include "cases/path_arguments.h"
#include "cases/shape_checks.h"
#include "cases/study_energy_model.h"
#include "cases/study_mesh.h"
#include "cases/sweep.h"
#include "error.h"
#include "io/one_line.h"
#include "mesh/fixed_region.h"
#include "surface_file/surface_file.h"

namespace tissue {
namespace {

/// Checks a user's text that goes into the fragment, and returns it. make and the shell would split or run other
/// characters. key: its key in the study; "": the name of the study's file.
const std::string& for_make(const Study& s, const std::string& key, const std::string& words) {
    const auto plain = [](unsigned char c) { return c < 128 && (std::isalnum(c) || std::strchr("._-+/", c)); };
    if (!words.empty() && words[0] != '-' && std::all_of(words.begin(), words.end(), plain)) return words;
    throw StudyError(one_line(fmt::format("{}: {}: '{}': make does not support this name; use only letters, digits and . _ - + /",
                                          s.file, key.empty() ? "its name" : "key '" + key + "'", words)));
}

/// Arguments of gmsh for fem/block.geo.
std::string mesh_arguments(const Study& s, int refine) {
    return fmt::format("-setnumber width {} -setnumber height {} -setnumber cells_x {} -setnumber cells_y {}",
                       s.geometry.width_m, s.geometry.height_m, s.cells[0] * refine, s.cells[1] * refine);
}

std::string collect_part(const Study& s, const std::vector<PlannedPath>& paths, const std::vector<PlannedHistory>& histories) {
    if (s.data)
        return fmt::format("cells {} {}\nsize {} {}\nfile {}\nseed {}\nparts {} {}\ntolerance {}\nnoise {}\n", s.cells[0],
                           s.cells[1], s.geometry.width_m, s.geometry.height_m, s.data->file, s.data->seed,
                           s.data->validation_part, s.data->held_out_part, s.data->surface_tolerance_m,
                           s.data->stated_force_noise.value_or(0)) +
               (s.data->histories.empty() ? "" : fmt::format("histories {}\n", s.data->histories));
    const std::string magnitudes = fmt::format("magnitudes {}\n", fmt::join(s.loads.magnitudes_m, " "));
    std::string text = s.geometry.is_solid() && s.geometry.is_block()
                           ? fmt::format("cells {}\nsize {} {} {}\n", fmt::join(s.cells, " "), s.geometry.width_m, s.geometry.length_m,
                                         s.geometry.height_m) + magnitudes
                       : s.geometry.is_block()
                           ? fmt::format("cells {} {}\nsize {} {}\nmagnitudes {}\n", s.cells[0], s.cells[1],
                                         s.geometry.width_m, s.geometry.height_m, fmt::join(s.loads.magnitudes_m, " "))
                           : fmt::format("shape {}\nmagnitudes {}\n", s.geometry.shape, fmt::join(s.loads.magnitudes_m, " "));
    for (const PlannedPath& p : paths) text += p.role + " " + p.push.name + "\n";
    for (const PlannedHistory& h : histories) text += fmt::format("history {} {} {}\n", h.kind, h.role, h.push.name);
    if (!histories.empty()) text += fmt::format("relaxes {}\n", s.material.relaxes() ? 1 : 0);
    return text;
}

std::string train_part(const Study& s) {
    const Study::Training& t = s.training;
    const auto optional = [](const std::optional<double>& v) { return v ? fmt::format("{}", *v) : std::string("none"); };
    std::string parts = s.geometry.bed_Pa_m.empty() ? "" : fmt::format("bed {}\n", fmt::join(s.geometry.bed_Pa_m, " "));
    for (const Study::Region& r : s.material.regions) parts += fmt::format("region {} {}\n", r.name, r.youngs_modulus_Pa());
    if (s.nodule) {
        const Inclusion& at = s.nodule->inclusion;
        parts += fmt::format("nodule {}{} {} {} {} {}\n", s.nodule->shape.empty() ? "" : s.nodule->shape + " ", at.centre_m()[0], at.centre_m()[1], at.centre_m()[2], at.radius_m(),
                             s.nodule->youngs_modulus_Pa());
    }
    if (s.material.relaxes()) {  // Maxwell branches of the energy model
        parts += fmt::format("relaxes {}{}\n", s.material.fits_shares ? "as measured " : "", s.material.long_term ? "long-term" : "instantaneous");
        for (const Branch& b : s.material.viscosity) parts += fmt::format("branch {} {}\n", b.share, b.tau_s);
        for (const Study::Region& r : s.material.regions) parts += fmt::format("shares {} {}\n", r.name, fmt::join(r.share, " "));
        if (s.nodule) parts += fmt::format("shares nodule {}\n", fmt::join(s.nodule->share, " "));
    }
    if (s.springs.is_energy_model())
        return parts + (s.springs.spacing_m > 0 ? fmt::format("spacing {}\n", s.springs.spacing_m) : "") + (s.springs.hookean ? "" : "curve material\n") + fmt::format("law {} cap {} {}\nterms {}\nmodulus {}\ndensity {}\nthickness {}\nscales {} {} ridge {}\nstarts {} seed {}\n",
                                     s.springs.topology, s.springs.area_cap_E2, s.material.formulation, fmt::join(s.springs.terms, " "),
                                     s.modulus_N_m(), s.material.density_kg_m3, s.geometry.thickness_m, t.force_scale,
                                     t.shape_scale, t.ridge, t.starts, t.seed);
    return parts + fmt::format(
        "springs {} {}\nobjective {} ridge {}\nmodulus {}\ndensity {}\nthickness {}\noptimizer {} also {}\nseed {}\niterations {}\n"
        "max_seconds {}\ntarget_rel_loss {}\nbox {} {}\nweight_near {} {}\nweight_far {} {}\n",
        s.springs.topology, s.springs.law, t.objective, t.ridge, s.modulus_N_m(), s.material.density_kg_m3,
        s.geometry.thickness_m, t.optimizer, fmt::join(t.also, " "), t.seed, t.iterations, optional(t.max_seconds), optional(t.target_rel_loss),
        t.k_min_E2, t.k_max_E2, t.weight_near[0], t.weight_near[1], t.weight_far[0], t.weight_far[1]);
}

/// The load path with whose arguments a history is solved. elastic: on tissue that does not relax.
PlannedPath path_of(const Study& s, const PlannedHistory& history, bool elastic) {
    PlannedPath path{history.push, history_role, history.push.depth_m, 1, s.refine, s.sizes_m};
    if (elastic) path.push.name = history.elastic_name();
    return path;
}

/// Arguments with which gmsh makes the shape's triangles or tetrahedra: it fills an outline or a surface, and converts
/// a mesh.
std::string shape_arguments(const Study& s) {
    if (is_surface_file(s.geometry.shape))
        return fmt::format("-setnumber size_near {0} -setnumber size_far {0}", s.spring_size_m);  // fem/fill3.geo
    if (s.spring_size_m > 0 && s.geometry.is_solid()) return fmt::format("-3 -clmin {0} -clmax {0}", s.spring_size_m / s.geometry.unit_m);
    if (s.spring_size_m > 0) return fmt::format("-2 -clmin {0} -clmax {0}", s.spring_size_m / s.geometry.unit_m);
    return "-save";
}

/// Files of the surfaces that `within` regions of geometry.fixed refer to, each after a blank.
std::string other_surfaces(const Study& s) {
    std::string files;
    for (const std::string& name : s.geometry.fixed)
        if (const auto other = FixedRegion::within(name)) files += " " + other->file;
    return files;
}

/// Names of the training paths, each after a blank: all of them, and up to 8 spread evenly over them for a first model.
struct TrainingNames {
    std::string all, first;
};
/// turns: number of directions that the paths take in turn. The first model gets about as many paths of each.
TrainingNames training_names(const std::vector<PlannedPath>& paths, std::size_t turns) {
    constexpr std::size_t most = 8;
    std::vector<std::vector<std::string>> of_kind(turns);
    TrainingNames names;
    std::size_t all = 0;
    for (const PlannedPath& path : paths) {
        if (path.role != "train") continue;
        names.all += " " + path.push.name;
        of_kind[all++ % turns].push_back(path.push.name);
    }
    const std::size_t some = std::min(most, all);
    for (std::size_t k = 0; k < some; ++k) {
        // picks: number of paths of this kind; each kind starts a fraction 1 / turns of a step after the one before
        const std::size_t kind = k % turns, picks = (some - kind + turns - 1) / turns;
        names.first += " " + of_kind[kind][k * of_kind[kind].size() / (picks * turns)];
    }
    return names;
}

std::string shape_part(const Study& s) {
    // each bed has a label of its own in the mesh
    const std::string beds = s.geometry.bed_Pa_m.empty() ? "" : fmt::format("beds {}\n", fmt::join(s.geometry.beds(), ","));
    return fmt::format("{}\n{}\nunit {}\nfixed {}\n{}regions {}\n", s.geometry.shape, shape_arguments(s), s.geometry.unit_m, fmt::join(s.geometry.fixed, ","), beds,
                       fmt::join(s.material.region_names(), ","));
}

}  // namespace

std::string shape_words(const Study& study) {
    return for_make(study, "geometry.shape", study.geometry.shape) + " " + shape_arguments(study);
}

Plan make_plan(const Study& study, const std::optional<Shape>& shape) {
    const bool solid = study.geometry.is_solid(), block = study.geometry.is_block() && !solid, shaped = !study.geometry.is_block();
    Plan plan;
    plan.fragment = fmt::format("# Written by tissuectl plan from study '{}'; do not edit.\n",
                                for_make(study, "", study.name));
    if (shaped) {
        plan.fragment += fmt::format("SHAPE := {}\nSHAPE_ARGUMENTS := {}\n$(R)/plan.mk: $(R)/mesh.msh\n",
                                     for_make(study, "geometry.shape", study.geometry.shape), shape_arguments(study));
        if (solid) {
            for (const std::string& name : study.geometry.fixed) {
                const auto other = FixedRegion::within(name);
                for_make(study, "geometry.fixed", other ? other->file : name);
            }
            // without wildcard a removed file would stop make before it writes the plan again
            if (const std::string others = other_surfaces(study); !others.empty()) plan.fragment += fmt::format("$(R)/mesh.made: $(wildcard{})\n", others);
            if (study.nodule && !study.nodule->shape.empty()) plan.fragment += fmt::format("$(R)/plan.mk: $(wildcard {})\n", for_make(study, "nodule.shape", study.nodule->shape));
            for (const std::string& name : study.material.region_names()) for_make(study, "material.regions", name);
        }
        plan.parts["shape"] = shape_part(study);
        if (!shape) return plan;
    }
    if (!shaped) refuse_wrong_unit(study);
    const SpringMesh springs = [&] {
        try {
            return study_mesh(study, shape, study.springs.topology);
        } catch (const MismatchError& e) {
            if (!shape && study.springs.spacing_m == 0) throw;
            throw StudyError(one_line(fmt::format("{}: key '{}': {}", study.file, study.springs.spacing_m > 0 ? "springs.spacing_m" : "geometry.shape", e.what())));
        }
    }();
    if (study.springs.is_energy_model()) try {
            Study rigid = study;  // the mesh may be older than the study's beds; make will then make it again
            rigid.geometry.bed_Pa_m.clear();
            study_energy_model(rigid, shape, springs);
        } catch (const MismatchError& e) {  // checked here so that the error does not come after hours of FE
            throw StudyError(one_line(fmt::format("{}: key 'springs.terms': {}", study.file, e.what())));
        }
    if (!study.data) refuse_tool(study, springs);
    const auto of_file = [&study](auto plan_them) {
        try {
            return plan_them();
        } catch (const StudyError&) {
            throw;
        } catch (const MismatchError& e) {
            throw StudyError(one_line(fmt::format("{}: {}", study.file, e.what())));
        }
    };
    const std::vector<PlannedPath> paths = study.data ? std::vector<PlannedPath>() : of_file([&] { return planned_paths(study, shape); });
    const std::vector<PlannedHistory> histories = study.data ? std::vector<PlannedHistory>() : of_file([&] { return planned_histories(study, shape); });
    refuse_push_through(study, springs, paths);
    refuse_unknown_discs(study, paths);
    std::string names;  // one list: make would copy the whole list for every `+=`
    for (const PlannedPath& path : paths) names += " " + path.push.name;
    for (const PlannedHistory& history : histories) {
        for (const PlannedPath& path : paths)
            if (path.push.name == history.push.name)
                throw StudyError(one_line(fmt::format("{}: key 'histories': '{}' of group '{}' is also the name of a load path; rename one, because both would have the same file",
                                                      study.file, history.push.name, history.group)));
        names += " " + history.push.name;
        if (history.has_elastic(study)) names += " " + history.elastic_name();
    }
    plan.fragment += fmt::format(
        "$(R)/cases.h5: CASES_COMMAND = {}\n"
        "$(R)/cases.h5: $(R)/plan/collect\n"
        "$(R)/cases.h5: $(BUILD)/stage/{}\n"
        "$(R)/model.h5: $(R)/plan/train\n"
        "PATHS :={}\n"
        "FIGURES := {}{}\n",
        study.data ? "import " + for_make(study, "data.file", study.data->file) + (study.data->histories.empty() ? "" : " --histories " + for_make(study, "data.histories", study.data->histories)) : "collect --paths $(R)/cases",
        study.data ? "import" : "collect", names,
        solid                    ? std::string(study.draws.empty() ? "" : "held_out held_out_force shape solid") + (study.map ? " map" : "")
        : study.springs.is_energy_model() ? study.data            ? "held_out"
                                 : study.draws.empty() ? "contours"
                                                       : "held_out held_out_force shape contours"
        : study.loads.sweep ? "held_out held_out_force shape contours springs"
                            : "contours force learning springs errors character",
        (study.data && !study.data->histories.empty()) ||
                std::any_of(histories.begin(), histories.end(), [](const PlannedHistory& h) { return h.role == "held_out"; })
            ? " histories"
            : "");
    plan.parts["collect"] = collect_part(study, paths, histories);
    plan.parts["train"] = train_part(study);
    if (study.data) {
        plan.fragment += fmt::format("$(R)/cases.h5: $(wildcard {}{})\n", study.data->file, study.data->histories.empty() ? "" : " " + study.data->histories);
        return plan;
    }
    if (block) {
        plan.fragment += fmt::format("$(R)/mesh.msh: MESH_ARGUMENTS = {}\n$(R)/mesh.msh: $(R)/plan/mesh\n",
                                     mesh_arguments(study, study.refine));
        plan.parts["mesh"] = mesh_arguments(study, study.refine) + "\n";
    }
    if (block && study.check_refine > 0) {
        plan.fragment += fmt::format(
            "$(R)/mesh-fine.msh: MESH_ARGUMENTS = {}\n"
            "$(R)/mesh-fine.msh: $(R)/plan/mesh-fine\n",
            mesh_arguments(study, study.check_refine));
        plan.parts["mesh-fine"] = mesh_arguments(study, study.check_refine) + "\n";
    }
    /// Adds the rule of a path. made_of: its prerequisites; part: text of its file of the plan.
    const auto solves = [&plan](const PlannedPath& path, const std::string& arguments, const std::string& made_of, const std::string& part) {
        plan.fragment += fmt::format("\n$(R)/cases/{0}.csv: PATH_ARGUMENTS = {1}\n$(R)/cases/{0}.csv: $(R)/plan/path-{0} {2}\n", path.push.name,
                                     arguments, made_of);
        plan.parts["path-" + path.push.name] = part + "\n";
    };
    /// Arguments of a path, its prerequisites, and the text of its file of the plan.
    struct Solve {
        std::string arguments, made_of, part;
    };
    const auto solve_of = [&](const PlannedPath& path) -> Solve {
        if (solid && shaped)  // solve_path calls tissuectl rim, which divides the surface along the disc's rim
            return {solid_shape_arguments(study, path, "$(R)/mesh.msh"), "$(R)/mesh.msh $(BUILD)/stage/rim scripts/run_gmsh fem/fill3.geo " + study.geometry.shape + other_surfaces(study) + (study.nodule && !study.nodule->shape.empty() ? " " + study.nodule->shape : ""),
                    solid_shape_arguments(study, path, "mesh.msh")};
        if (solid) return {solid_arguments(study, path), std::string("scripts/run_gmsh ") + solid_geo, solid_arguments(study, path)};
        const std::string arguments = path_arguments(study, path), mesh = !block || path.refine == study.refine ? "mesh.msh" : "mesh-fine.msh";
        return {"-mesh $(R)/" + mesh + " " + arguments, "$(R)/" + mesh, mesh + " " + arguments};
    };
    const TrainingNames trained = training_names(paths, study.loads.spread && study.loads.spread->pushes_each == 1 ? study.loads.spread->pushes_deg.size() : 1);
    plan.fragment += fmt::format("TRAINED :={}\nFIRST_TRAINED :={}\n", trained.all, trained.first);
    if (const auto first = std::find_if(paths.begin(), paths.end(), [](const PlannedPath& path) { return path.role == "train"; }); first != paths.end())
        plan.fragment += "TRAINED_MADE_OF := " + solve_of(*first).made_of + "\n";
    if (solid && !shaped) plan.fragment += fmt::format("SOLID := {}\n", solid_geo);
    for (const PlannedPath& path : paths) {
        const Solve solve = solve_of(path);
        solves(path, solve.arguments, solve.made_of, solve.part);
    }
    for (const Study::Histories& group : study.histories)  // the plan depends on the trajectory in the file
        if (!group.file.empty()) plan.fragment += "\n$(R)/plan.mk: $(wildcard " + for_make(study, "histories.file", group.file) + ")\n";
    for (const PlannedHistory& history : histories) {
        const std::string trajectory = "history-" + history.push.name;
        plan.parts[trajectory] = trajectory_text(history.trajectory);
        for (const bool elastic : {false, true}) {
            if (elastic && !history.has_elastic(study)) continue;
            const PlannedPath path = path_of(study, history, elastic);
            const Solve solve = solve_of(path);
            const bool relaxes = study.material.relaxes() && !elastic;
            solves(path, solve.arguments + history_arguments(study, history, "$(R)/plan/" + trajectory, relaxes), "$(R)/plan/" + trajectory + " " + solve.made_of,
                   solve.part + history_arguments(study, history, trajectory, relaxes));
        }
    }
    return plan;
}

}  // namespace tissue
