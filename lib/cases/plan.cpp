#include "cases/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cases/sweep.h"

namespace tissue {
namespace {

/// For gmsh, fem/block.geo.
std::string mesh_arguments(const Study& s, int refine) {
    return fmt::format("-setnumber width {} -setnumber height {} -setnumber cells_x {} -setnumber cells_y {}",
                       s.geometry.width_m, s.geometry.height_m, s.cells[0] * refine, s.cells[1] * refine);
}

/// For FreeFEM, fem/solve_path.edp. Numbers are written so that they read back to the same bits.
std::string path_arguments(const Study& s, const PlannedPath& path) {
    const StudyPath& p = path.push;
    return fmt::format(
        "-width {} -height {} -thickness {} -C1 {} -C2 {} -cells_x {} -cells_y {} -contact_x {} -contact_y {} "
        "-direction_x {} -direction_y {} -depth {} -records {} -tolerance {} -max_newton {} -formulation {} "
        "-indenter {} -patch_half_width {} -allow_lost {}",
        s.geometry.width_m, s.geometry.height_m, s.geometry.thickness_m, s.material.C1_Pa, s.material.C2_Pa, s.cells[0],
        s.cells[1], p.contact_m.x(), p.contact_m.y(), p.direction.x(), p.direction.y(), path.depth_m,
        path.records, s.solver.tolerance, s.solver.max_newton, s.material.formulation, s.indenter.kind,
        s.indenter.half_width_m, s.loads.sweep || path.role == "check" ? 1 : 0);
}

std::string collect_part(const Study& s) {
    std::string text = fmt::format("cells {} {}\nsize {} {}\nmagnitudes {}\n", s.cells[0], s.cells[1],
                                   s.geometry.width_m, s.geometry.height_m, fmt::join(s.loads.magnitudes_m, " "));
    for (const PlannedPath& p : planned_paths(s)) text += p.role + " " + p.push.name + "\n";
    return text;
}

std::string train_part(const Study& s) {
    const Study::Training& t = s.training;
    const auto optional = [](const std::optional<double>& v) { return v ? fmt::format("{}", *v) : std::string("none"); };
    return fmt::format(
        "springs {} {}\nobjective {} ridge {} reach {}\nmodulus {}\ndensity {}\nthickness {}\noptimizer {} also {}\nseed {}\niterations {}\n"
        "max_seconds {}\ntarget_rel_loss {}\nbox {} {}\nweight_near {} {}\nweight_far {} {}\n",
        s.springs.topology, s.springs.law, t.objective, t.ridge, t.reach_m, s.modulus_N_m(), s.material.density_kg_m3, s.geometry.thickness_m,
        t.optimizer, fmt::join(t.also, " "), t.seed, t.iterations, optional(t.max_seconds), optional(t.target_rel_loss),
        t.k_min_E2, t.k_max_E2, t.weight_near[0], t.weight_near[1], t.weight_far[0], t.weight_far[1]);
}

}  // namespace

Plan make_plan(const Study& study) {
    Plan plan;
    plan.fragment = fmt::format(
        "# Written by tissuectl plan from study '{}'; do not edit.\n"
        "$(R)/mesh.msh: MESH_ARGUMENTS = {}\n"
        "$(R)/mesh.msh: $(R)/plan/mesh\n"
        "$(R)/cases.h5: $(R)/plan/collect\n"
        "$(R)/model.h5: $(R)/plan/train\n"
        "PATHS :=\n"
        "FIGURES := {}\n",
        study.name, mesh_arguments(study, study.refine),
        study.loads.sweep ? "held_out held_out_force contours springs"
                          : "contours force learning springs errors character");
    plan.parts["mesh"] = mesh_arguments(study, study.refine) + "\n";
    if (study.check_refine > 0) {
        plan.fragment += fmt::format(
            "$(R)/mesh-fine.msh: MESH_ARGUMENTS = {}\n"
            "$(R)/mesh-fine.msh: $(R)/plan/mesh-fine\n",
            mesh_arguments(study, study.check_refine));
        plan.parts["mesh-fine"] = mesh_arguments(study, study.check_refine) + "\n";
    }
    plan.parts["collect"] = collect_part(study);
    plan.parts["train"] = train_part(study);
    for (const PlannedPath& path : planned_paths(study)) {
        const std::string arguments = path_arguments(study, path),
                          mesh = path.refine == study.refine ? "mesh.msh" : "mesh-fine.msh";
        plan.fragment += fmt::format(
            "\nPATHS += {0}\n"
            "$(R)/cases/{0}.csv: PATH_ARGUMENTS = -mesh $(R)/{2} {1}\n"
            "$(R)/cases/{0}.csv: $(R)/plan/path-{0} $(R)/{2}\n",
            path.push.name, arguments, mesh);
        plan.parts["path-" + path.push.name] = mesh + " " + arguments + "\n";
    }
    return plan;
}

}  // namespace tissue
