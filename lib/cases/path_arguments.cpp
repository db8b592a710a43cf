#include "cases/path_arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mesh/surface.h"

namespace tissue {
namespace {

constexpr int nodule_label = 11;  ///< label of the nodule's elements

/// Constitutive parameters for FreeFEM. ending: "" for the base material, "_11" for the elements with label 11.
std::string parameter_arguments(const Study::MaterialParameters& p, const std::string& ending) {
    if (p.alpha.empty()) return fmt::format("-C1{2} {0} -C2{2} {1}", p.C1_Pa, p.C2_Pa, ending);
    std::string text;
    for (std::size_t k = 0; k < p.alpha.size(); ++k)
        text += fmt::format("{4}-mu{0}{3} {1} -alpha{0}{3} {2}", k + 1, p.mu_Pa[k], p.alpha[k], ending, k ? " " : "");
    return text;
}

/// Material law and parameters for FreeFEM: those of the base material, then those of the named regions.
std::string material_arguments(const Study::Material& m) {
    std::string text = parameter_arguments(m, "");
    if (m.law == "ogden") text = fmt::format("-law ogden -terms {} ", m.alpha.size()) + text;
    int label = 10;
    for (const Study::Region& r : m.regions) text += " " + parameter_arguments(r, fmt::format("_{}", ++label));
    return text;
}

/// The Maxwell branches of one material for FreeFEM. Relaxation times are only given for the base material.
std::string branch_arguments(const Study::MaterialParameters& p, const std::vector<Branch>& branches, const std::string& ending) {
    std::string text;
    for (std::size_t k = 0; k < branches.size(); ++k) {
        text += fmt::format(" -g{}{} {}", k + 1, ending, p.share[k]);
        if (ending.empty()) text += fmt::format(" -tau{} {}", k + 1, branches[k].tau_s);
    }
    return text;
}

/// Prony series for FreeFEM: relaxation times and relative moduli of the base material, then relative moduli of the
/// regions or of the nodule.
std::string viscosity_arguments(const Study& s) {
    const std::vector<Branch>& branches = s.material.viscosity;
    std::string text = fmt::format(" -branches {}", branches.size()) + branch_arguments(s.material, branches, "");
    int label = 10;
    for (const Study::Region& r : s.material.regions) text += branch_arguments(r, branches, fmt::format("_{}", ++label));
    if (s.nodule) text += branch_arguments(*s.nodule, branches, fmt::format("_{}", nodule_label));
    return text;
}

/// Place of the nodule for gmsh and its material for FreeFEM; empty where there is none.
std::string nodule_arguments(const Study& s) {
    if (!s.nodule) return "";
    const Inclusion& at = s.nodule->inclusion;
    const std::string& shape = s.nodule->shape;
    return fmt::format("{} -nodule_x {} -nodule_y {} -nodule_z {} -nodule_radius {} {}", shape.empty() ? "" : " -nodule_shape " + shape, at.centre_m()[0], at.centre_m()[1],
                       at.centre_m()[2], at.radius_m(), parameter_arguments(*s.nodule, fmt::format("_{}", nodule_label)));
}

}  // namespace

std::string history_arguments(const Study& s, const PlannedHistory& history, const std::string& file, bool relaxes) {
    std::string text = fmt::format(" -history {} -density {}", file, s.material.density_kg_m3);
    if (history.second_contact_m) text += fmt::format(" -second_x {} -second_y {}", history.second_contact_m->x(), history.second_contact_m->y());
    return relaxes ? text + viscosity_arguments(s) : text;
}

std::string solid_arguments(const Study& s, const PlannedPath& path) {
    const Study::Geometry& g = s.geometry;
    const StudyPath& p = path.push;
    std::string second;
    if (p.second)
        second = fmt::format(" -second_x {} -second_y {} -second_z {} -second_direction_x {} -second_direction_y {} -second_direction_z {} -second_depth {}", p.second->contact_m[0],
                             p.second->contact_m[1], p.second->contact_m[2], p.second->direction[0], p.second->direction[1], p.second->direction[2], p.second->depth_m);
    return fmt::format(
        "-geo {} -width {} -length {} -height {} -cells_x {} -cells_y {} -cells_z {} -size_near {} -size_far {} {}{} -contact_x {} "
        "-contact_y {} -contact_z {} -direction_x {} -direction_y {} -direction_z {} -disc_radius {} -depth {} -records {} -tolerance {} "
        "-max_newton {} -allow_lost 1{}",
        solid_geo, g.width_m, g.length_m, g.height_m, s.cells[0], s.cells[1], s.cells[2], path.sizes_m[0], path.sizes_m[1],
        material_arguments(s.material), nodule_arguments(s), p.contact_m[0], p.contact_m[1], p.contact_m[2], p.direction[0], p.direction[1],
        p.direction[2], p.radius_m, path.depth_m, path.records, s.solver.tolerance, s.solver.max_newton, second);
}

std::string solid_shape_arguments(const Study& s, const PlannedPath& path, const std::string& springs) {
    const StudyPath& p = path.push;
    const std::vector<std::string> regions = s.material.region_names();
    std::string beds;
    if (const std::vector<double> stiffness = s.geometry.beds_Pa_m(); !stiffness.empty()) {
        beds = fmt::format(" -beds {}", fmt::join(s.geometry.beds(), ","));
        for (std::size_t b = 0; b < stiffness.size(); ++b) beds += fmt::format(" -bed_{} {}", fixed_label_of(static_cast<int>(b) + 1), stiffness[b]);
    }
    return fmt::format(
        "-shape {} -unit_m {} -fixed {}{}{} -springs {} -size_near {} -size_far {} {}{} -contact_x {} -contact_y {} -contact_z {} "
        "-direction_x {} -direction_y {} -direction_z {} -disc_radius {} -depth {} -records {} -tolerance {} -max_newton {} -allow_lost 1",
        s.geometry.shape, s.geometry.unit_m, fmt::join(s.geometry.fixed, ","),
        beds,
        regions.empty() ? "" : fmt::format(" -regions {}", fmt::join(regions, ",")), springs, path.sizes_m[0], path.sizes_m[1],
        material_arguments(s.material), nodule_arguments(s), p.contact_m[0], p.contact_m[1], p.contact_m[2], p.direction[0], p.direction[1],
        p.direction[2], p.radius_m, path.depth_m, path.records, s.solver.tolerance, s.solver.max_newton);
}

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
        size, g.thickness_m, material_arguments(s.material), lattice, p.contact_m.x(), p.contact_m.y(), p.direction.x(),
        p.direction.y(), path.depth_m, path.records, s.solver.tolerance, s.solver.max_newton, s.material.formulation,
        s.indenter.kind, s.indenter.half_width_m, s.loads.sweep || path.role == "check" || path.role == history_role ? 1 : 0);
}

}  // namespace tissue
