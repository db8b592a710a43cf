#include "cases/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "cases/history_plan.h"
#include "cases/path_arguments.h"
#include "cases/shape_checks.h"
#include "cases/study_law.h"
#include "cases/study_mesh.h"
#include "cases/sweep.h"
#include "error.h"
#include "io/one_line.h"
#include "mesh/held_region.h"
#include "surface_file/surface_file.h"

namespace tissue {
namespace {

/// Words that a person wrote, as they stand in the fragment. make and the shell would take others apart, or run them.
/// key: where they stand in the study; "" is the name of its file.
const std::string& for_make(const Study& s, const std::string& key, const std::string& words) {
    const auto plain = [](unsigned char c) { return c < 128 && (std::isalnum(c) || std::strchr("._-+/", c)); };
    if (!words.empty() && words[0] != '-' && std::all_of(words.begin(), words.end(), plain)) return words;
    throw StudyError(one_line(fmt::format("{}: {}: '{}': make cannot carry this name; use letters, digits and . _ - + / alone",
                                          s.file, key.empty() ? "its name" : "key '" + key + "'", words)));
}

/// For gmsh, fem/block.geo.
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
    if (s.material.relaxes()) {  // which branches the law gets
        parts += fmt::format("relaxes {}{}\n", s.material.fits_shares ? "as measured " : "", s.material.long_term ? "long-term" : "instantaneous");
        for (const Branch& b : s.material.viscosity) parts += fmt::format("branch {} {}\n", b.share, b.tau_s);
        for (const Study::Region& r : s.material.regions) parts += fmt::format("shares {} {}\n", r.name, fmt::join(r.share, " "));
        if (s.nodule) parts += fmt::format("shares nodule {}\n", fmt::join(s.nodule->share, " "));
    }
    if (s.springs.is_law())
        return parts + (s.springs.spacing_m > 0 ? fmt::format("spacing {}\n", s.springs.spacing_m) : "") + fmt::format("law {} cap {} {}\nterms {}\nmodulus {}\ndensity {}\nthickness {}\nscales {} {} ridge {}\nstarts {} seed {}\n",
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

/// A history as a path that is solved. elastic: on tissue that does not relax.
PlannedPath path_of(const Study& s, const PlannedHistory& history, bool elastic) {
    PlannedPath path{history.push, history_role, history.push.depth_m, 1, s.refine, s.sizes_m};
    if (elastic) path.push.name = history.elastic_name();
    return path;
}

/// How gmsh makes the shape's triangles or tetrahedra: an outline or a surface is filled, a mesh is converted.
std::string shape_arguments(const Study& s) {
    if (is_surface_file(s.geometry.shape))
        return fmt::format("-setnumber size_near {0} -setnumber size_far {0}", s.spring_size_m);  // fem/fill3.geo
    if (s.spring_size_m > 0 && s.geometry.is_solid()) return fmt::format("-3 -clmin {0} -clmax {0}", s.spring_size_m / s.geometry.unit_m);
    if (s.spring_size_m > 0) return fmt::format("-2 -clmin {0} -clmax {0}", s.spring_size_m / s.geometry.unit_m);
    return "-save";
}

/// Files of the surfaces that regions of geometry.fixed are within, each after a blank.
std::string other_surfaces(const Study& s) {
    std::string files;
    for (const std::string& name : s.geometry.fixed)
        if (const auto other = HeldRegion::within(name)) files += " " + other->file;
    return files;
}

/// Load paths to train on, and so many of them spread over all, for a first model: names, each after a blank.
struct TrainingNames {
    std::string all, first;
};
/// turns: kinds of pushes that the paths take in turn, of which a first model has as many of each.
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
        const std::size_t kind = k % turns, picks = (some - kind + turns - 1) / turns;  // of this kind; each of them a part of a step after the kind before
        names.first += " " + of_kind[kind][k * of_kind[kind].size() / (picks * turns)];
    }
    return names;
}

std::string shape_part(const Study& s) {
    const std::string beds = s.geometry.bed_Pa_m.empty() ? "" : fmt::format("beds {}\n", fmt::join(s.geometry.beds(), ","));  // which parts have labels of their own
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
                const auto other = HeldRegion::within(name);
                for_make(study, "geometry.fixed", other ? other->file : name);
            }
            if (const std::string others = other_surfaces(study); !others.empty()) plan.fragment += fmt::format("$(R)/mesh.made: $(wildcard{})\n", others);  // without wildcard a removed file would stop make before it rewrites the plan
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
    if (study.springs.is_law()) try {
            Study rigid = study;  // the mesh may be of before the beds, and made again next
            rigid.geometry.bed_Pa_m.clear();
            study_law(rigid, shape, springs);
        } catch (const MismatchError& e) {  // before hours of FE, not after
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
    std::string names;  // all at once: make copies the whole list for every name that is added to it
    for (const PlannedPath& path : paths) names += " " + path.push.name;
    for (const PlannedHistory& history : histories) {
        for (const PlannedPath& path : paths)
            if (path.push.name == history.push.name)
                throw StudyError(one_line(fmt::format("{}: key 'histories': '{}' of group '{}' is also the name of a load path, and they would share one file",
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
        : study.springs.is_law() ? study.data            ? "held_out"
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
    /// How a path is solved, what it is made of, and what its part of the plan says.
    const auto solves = [&plan](const PlannedPath& path, const std::string& arguments, const std::string& made_of, const std::string& part) {
        plan.fragment += fmt::format("\n$(R)/cases/{0}.csv: PATH_ARGUMENTS = {1}\n$(R)/cases/{0}.csv: $(R)/plan/path-{0} {2}\n", path.push.name,
                                     arguments, made_of);
        plan.parts["path-" + path.push.name] = part + "\n";
    };
    /// The arguments of a path, what they are made of, and what its part says of them.
    struct Solve {
        std::string arguments, made_of, part;
    };
    const auto solve_of = [&](const PlannedPath& path) -> Solve {
        if (solid && shaped)  // tissuectl rim divides its surface
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
    for (const Study::Histories& group : study.histories)  // another course in it is another plan
        if (!group.file.empty()) plan.fragment += "\n$(R)/plan.mk: $(wildcard " + for_make(study, "histories.file", group.file) + ")\n";
    for (const PlannedHistory& history : histories) {
        const std::string course = "history-" + history.push.name;
        plan.parts[course] = course_text(history.course);
        for (const bool elastic : {false, true}) {
            if (elastic && !history.has_elastic(study)) continue;
            const PlannedPath path = path_of(study, history, elastic);
            const Solve solve = solve_of(path);
            const bool relaxes = study.material.relaxes() && !elastic;
            solves(path, solve.arguments + history_arguments(study, history, "$(R)/plan/" + course, relaxes), "$(R)/plan/" + course + " " + solve.made_of,
                   solve.part + history_arguments(study, history, course, relaxes));
        }
    }
    return plan;
}

}  // namespace tissue
