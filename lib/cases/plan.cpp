#include "cases/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "cases/history_plan.h"
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

constexpr const char* solid_geo = "fem/block3.geo";  ///< of which scripts/solve_path makes a mesh a path
constexpr int nodule_label = 11;                     ///< of its elements there
constexpr const char* history_role = "history";      ///< of a path that is solved along a course

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

/// A law's parameters for FreeFEM. ending: "" of the base material, "_11" of the elements labelled so.
std::string parameter_arguments(const Study::LawParameters& p, const std::string& ending) {
    if (p.alpha.empty()) return fmt::format("-C1{2} {0} -C2{2} {1}", p.C1_Pa, p.C2_Pa, ending);
    std::string text;
    for (std::size_t k = 0; k < p.alpha.size(); ++k)
        text += fmt::format("{4}-mu{0}{3} {1} -alpha{0}{3} {2}", k + 1, p.mu_Pa[k], p.alpha[k], ending, k ? " " : "");
    return text;
}

/// The law and its parameters for FreeFEM; those of the named regions after the base material's.
std::string law_arguments(const Study::Material& m) {
    std::string text = parameter_arguments(m, "");
    if (m.law == "ogden") text = fmt::format("-law ogden -terms {} ", m.alpha.size()) + text;
    int label = 10;
    for (const Study::Region& r : m.regions) text += " " + parameter_arguments(r, fmt::format("_{}", ++label));
    return text;
}

/// The branches of one material for FreeFEM.
std::string branch_arguments(const Study::LawParameters& p, const std::vector<Branch>& branches, const std::string& ending) {
    std::string text;
    for (std::size_t k = 0; k < branches.size(); ++k) {
        text += fmt::format(" -g{}{} {}", k + 1, ending, p.share[k]);
        if (ending.empty()) text += fmt::format(" -tau{} {}", k + 1, branches[k].tau_s);
    }
    return text;
}

/// How the tissue relaxes, for FreeFEM: times and shares of the base material, then shares of the regions or the nodule.
std::string viscosity_arguments(const Study& s) {
    const std::vector<Branch>& branches = s.material.viscosity;
    std::string text = fmt::format(" -branches {}", branches.size()) + branch_arguments(s.material, branches, "");
    int label = 10;
    for (const Study::Region& r : s.material.regions) text += branch_arguments(r, branches, fmt::format("_{}", ++label));
    if (s.nodule) text += branch_arguments(*s.nodule, branches, fmt::format("_{}", nodule_label));
    return text;
}

/// What a history needs beside the arguments of a path. file: of its course.
std::string history_arguments(const Study& s, const PlannedHistory& history, const std::string& file, bool relaxes) {
    std::string text = fmt::format(" -history {} -density {}", file, s.material.density_kg_m3);
    if (history.second_contact_m) text += fmt::format(" -second_x {} -second_y {}", history.second_contact_m->x(), history.second_contact_m->y());
    return relaxes ? text + viscosity_arguments(s) : text;
}

/// The nodule's place for gmsh and its material for FreeFEM; nothing where there is none.
std::string nodule_arguments(const Study& s) {
    if (!s.nodule) return "";
    const Inclusion at = study_inclusion(s);
    const std::string& shape = s.nodule->shape;
    return fmt::format("{} -nodule_x {} -nodule_y {} -nodule_z {} -nodule_radius {} {}", shape.empty() ? "" : " -nodule_shape " + for_make(s, "nodule.shape", shape), at.centre_m()[0], at.centre_m()[1],
                       at.centre_m()[2], shape.empty() ? s.nodule->radius_m : at.radius_m(), parameter_arguments(*s.nodule, fmt::format("_{}", nodule_label)));
}

/// For scripts/solve_path, which shares them between gmsh and fem/solve_solid.edp.
std::string solid_arguments(const Study& s, const PlannedPath& path) {
    const Study::Geometry& g = s.geometry;
    const StudyPath& p = path.push;
    return fmt::format(
        "-geo {} -width {} -length {} -height {} -cells_x {} -cells_y {} -cells_z {} -size_near {} -size_far {} {}{} -contact_x {} "
        "-contact_y {} -contact_z {} -direction_x {} -direction_y {} -direction_z {} -disc_radius {} -depth {} -records {} -tolerance {} "
        "-max_newton {} -allow_lost 1",
        solid_geo, g.width_m, g.length_m, g.height_m, s.cells[0], s.cells[1], s.cells[2], path.sizes_m[0], path.sizes_m[1],
        law_arguments(s.material), nodule_arguments(s), p.contact_m[0], p.contact_m[1], p.contact_m[2], p.direction[0], p.direction[1],
        p.direction[2], s.indenter.radius_m, path.depth_m, path.records, s.solver.tolerance, s.solver.max_newton);
}

/// For scripts/solve_path, of a solid shape. springs: the mesh whose nodes are asked for.
std::string solid_shape_arguments(const Study& s, const PlannedPath& path, const std::string& springs) {
    const StudyPath& p = path.push;
    const std::vector<std::string> regions = s.material.region_names();
    return fmt::format(
        "-shape {} -unit_m {} -fixed {}{}{} -springs {} -size_near {} -size_far {} {}{} -contact_x {} -contact_y {} -contact_z {} "
        "-direction_x {} -direction_y {} -direction_z {} -disc_radius {} -depth {} -records {} -tolerance {} -max_newton {} -allow_lost 1",
        s.geometry.shape, s.geometry.unit_m, fmt::join(s.geometry.fixed, ","),
        s.geometry.bed_Pa_m > 0 ? fmt::format(" -bed {}", s.geometry.bed_Pa_m) : "",
        regions.empty() ? "" : fmt::format(" -regions {}", fmt::join(regions, ",")), springs, path.sizes_m[0], path.sizes_m[1],
        law_arguments(s.material), nodule_arguments(s), p.contact_m[0], p.contact_m[1], p.contact_m[2], p.direction[0], p.direction[1],
        p.direction[2], s.indenter.radius_m, path.depth_m, path.records, s.solver.tolerance, s.solver.max_newton);
}

/// For FreeFEM, fem/solve_path.edp. Numbers are written so that they read back to the same bits.
std::string path_arguments(const Study& s, const PlannedPath& path) {
    const StudyPath& p = path.push;
    const Study::Geometry& g = s.geometry;
    const std::string size = g.is_block() ? fmt::format("-width {} -height {} ", g.width_m, g.height_m) : "",
                      lattice = g.is_block() ? fmt::format("-cells_x {} -cells_y {}", s.cells[0], s.cells[1])
                                             : fmt::format("-refine {}", path.refine);
    return fmt::format(
        "{}-thickness {} {} {} -contact_x {} -contact_y {} "
        "-direction_x {} -direction_y {} -depth {} -records {} -tolerance {} -max_newton {} -formulation {} "
        "-indenter {} -patch_half_width {} -allow_lost {}",
        size, g.thickness_m, law_arguments(s.material), lattice, p.contact_m.x(), p.contact_m.y(), p.direction.x(),
        p.direction.y(), path.depth_m, path.records, s.solver.tolerance, s.solver.max_newton, s.material.formulation,
        s.indenter.kind, s.indenter.half_width_m, s.loads.sweep || path.role == "check" || path.role == history_role ? 1 : 0);
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
    std::string parts = s.geometry.bed_Pa_m > 0 ? fmt::format("bed {}\n", s.geometry.bed_Pa_m) : "";
    for (const Study::Region& r : s.material.regions) parts += fmt::format("region {} {}\n", r.name, r.youngs_modulus_Pa());
    if (s.nodule) {
        const Inclusion at = study_inclusion(s);
        parts += fmt::format("nodule {}{} {} {} {} {}\n", s.nodule->shape.empty() ? "" : s.nodule->shape + " ", at.centre_m()[0], at.centre_m()[1], at.centre_m()[2],
                             s.nodule->shape.empty() ? s.nodule->radius_m : at.radius_m(), s.nodule->youngs_modulus_Pa());
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

/// Files of the surfaces that regions of geometry.fixed are within, and of the nodule's, each after a blank.
std::string other_surfaces(const Study& s) {
    std::string files;
    for (const std::string& name : s.geometry.fixed)
        if (const auto other = HeldRegion::within(name)) files += " " + other->file;
    if (s.nodule && !s.nodule->shape.empty()) files += " " + s.nodule->shape;
    return files;
}

/// Load paths to train on, and so many of them spread over all, for a first model: names, each after a blank.
struct TrainingNames {
    std::string all, first;
};
TrainingNames training_names(const std::vector<PlannedPath>& paths) {
    constexpr std::size_t most = 8;
    std::vector<std::string> trained;
    for (const PlannedPath& path : paths)
        if (path.role == "train") trained.push_back(path.push.name);
    TrainingNames names;
    for (const std::string& name : trained) names.all += " " + name;
    const std::size_t all = trained.size(), some = std::min(most, all);
    const bool even = some > 0 && all % some == 0 && all / some % 2 == 0;  // of two pushes that take turns, such steps would meet one alone
    for (std::size_t k = 0; k < some; ++k) names.first += " " + trained[k * all / some + (even ? k % 2 : 0)];
    return names;
}

std::string shape_part(const Study& s) {
    return fmt::format("{}\n{}\nunit {}\nfixed {}\nregions {}\n", s.geometry.shape, shape_arguments(s), s.geometry.unit_m,
                       fmt::join(s.geometry.fixed, ","), fmt::join(s.material.region_names(), ","));
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
    const SpringMesh springs = [&] {
        try {
            return study_mesh(study, shape, study.springs.topology);
        } catch (const MismatchError& e) {
            if (!shape) throw;
            throw StudyError(one_line(fmt::format("{}: key '{}': {}", study.file, study.springs.spacing_m > 0 ? "springs.spacing_m" : "geometry.shape", e.what())));
        }
    }();
    if (study.springs.is_law()) try {
            study_law(study, shape, springs);
        } catch (const MismatchError& e) {  // before hours of FE, not after
            throw StudyError(one_line(fmt::format("{}: key 'springs.terms': {}", study.file, e.what())));
        }
    if (!study.data) refuse_tool(study, springs);
    const std::vector<PlannedPath> paths = study.data ? std::vector<PlannedPath>() : planned_paths(study, shape);
    const std::vector<PlannedHistory> histories = study.data ? std::vector<PlannedHistory>() : planned_histories(study, shape);
    refuse_push_through(study, springs, paths);
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
            return {solid_shape_arguments(study, path, "$(R)/mesh.msh"), "$(R)/mesh.msh $(BUILD)/stage/rim scripts/run_gmsh fem/fill3.geo " + study.geometry.shape + other_surfaces(study),
                    solid_shape_arguments(study, path, "mesh.msh")};
        if (solid) return {solid_arguments(study, path), std::string("scripts/run_gmsh ") + solid_geo, solid_arguments(study, path)};
        const std::string arguments = path_arguments(study, path), mesh = !block || path.refine == study.refine ? "mesh.msh" : "mesh-fine.msh";
        return {"-mesh $(R)/" + mesh + " " + arguments, "$(R)/" + mesh, mesh + " " + arguments};
    };
    const TrainingNames trained = training_names(paths);
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
