#include "export/csv.h"

#include <fmt/format.h>

#include <algorithm>

namespace tissue {
namespace {

constexpr const char* axis_names = "xyz";

/// "u_x_m,u_y_m" for columns("u_", "_m", 2).
std::string columns(const std::string& before, const std::string& after, Eigen::Index dimension) {
    std::string text;
    for (Eigen::Index d = 0; d < dimension; ++d)
        text += fmt::format("{}{}{}{}", d > 0 ? "," : "", before, axis_names[d], after);
    return text;
}

template <class Row>
std::string values(const Row& row) {
    std::string text;
    for (Eigen::Index d = 0; d < row.size(); ++d) text += fmt::format("{}{}", d > 0 ? "," : "", row[d]);
    return text;
}

/// Quoted where a comma or quote stands in it.
std::string field(const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

std::string nodes_csv(const TissueModel& model) {
    const SpringMesh& mesh = model.mesh;
    std::string nodes = "node," + columns("", "_m", mesh.dimension()) + ",mass_kg,fixed\n";
    for (int i = 0; i < mesh.node_count(); ++i)
        nodes += fmt::format("{},{},{},{}\n", i, values(mesh.nodes.row(i)), model.node_mass_kg[i],
                             std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), i) ? 1 : 0);
    return nodes;
}

/// With a column of one stiffness that serves all cases.
std::string springs_csv(const TissueModel& model, const std::string& name, const Eigen::VectorXd& theta) {
    const SpringMesh& mesh = model.mesh;
    std::string springs = "spring,node_i,node_j,rest_length_m,heuristic_a_N_m,heuristic_b_N_m," + name + "\n";
    for (int s = 0; s < mesh.spring_count(); ++s)
        springs += fmt::format("{},{},{},{},{},{},{}\n", s, mesh.springs(s, 0), mesh.springs(s, 1), mesh.rest_length(s),
                               model.heuristic_a[s], model.heuristic_b[s], theta[s]);
    return springs;
}

std::string triangles_csv(const SpringMesh& mesh) {
    std::string triangles = "node_i,node_j,node_k\n";
    for (Eigen::Index t = 0; t < mesh.simplices.rows(); ++t) triangles += values(mesh.simplices.row(t)) + "\n";
    return triangles;
}

}  // namespace

Files csv_files(const TissueModel& model, const std::vector<NamedSet>& sets) {
    const SpringMesh& mesh = model.mesh;
    const int D = mesh.dimension();
    std::string stiffness = "spring";
    for (const NamedSet& set : sets) stiffness += "," + field(set.name);
    stiffness += '\n';
    for (int s = 0; s < mesh.spring_count(); ++s) {
        stiffness += std::to_string(s);
        for (const NamedSet& set : sets) stiffness += fmt::format(",{}", set.theta[s]);
        stiffness += '\n';
    }
    std::string table = "set," + columns("contact_", "_m", D) + "," + columns("push_", "", D) + ",magnitude_m\n";
    for (const NamedSet& set : sets)
        if (const int c = set.load_case; c >= 0)
            table += fmt::format("{},{},{},{}\n", field(set.name), values(model.contact_m.row(c)),
                                 values(model.direction.row(c)), model.magnitude_m[c]);
    return {{"nodes.csv", nodes_csv(model)},
            {"springs.csv", springs_csv(model, "one_set_N_m", model.one_set)},
            {"triangles.csv", triangles_csv(mesh)},
            {"sets.csv", table},
            {"stiffness.csv", stiffness}};
}

Files csv_files(const TissueModel& model, const std::vector<PressedCase>& cases) {
    const SpringMesh& mesh = model.mesh;
    const LawModel& law = *model.energy_law;
    const LawTables tables = law_tables(model);
    const int D = mesh.dimension();
    std::string areas = "area,kind,rest_area_m2,stiffness_N_m\n", edges = "area,node_i,node_j\n";
    for (std::size_t e = 0; e < tables.area_kind.size(); ++e) {
        const auto i = static_cast<Eigen::Index>(e);
        areas += fmt::format("{},{},{},{}\n", e, tables.area_kind[e], tables.area_m2[i], tables.area_N_m[i]);
    }
    for (std::size_t k = 0; k < tables.edge_area.size(); ++k)
        edges += fmt::format("{},{},{}\n", tables.edge_area[k], tables.edge_from[k], tables.edge_to[k]);
    std::string terms = "term,coefficient\n", contact = "row,log_k_N_m,phase,corner,edge\n", surface = "node,arc_m\n";
    for (std::size_t t = 0; t < law.terms.size(); ++t)
        terms += fmt::format("{},{}\n", field(law.terms[t]), law.coefficients[static_cast<Eigen::Index>(t)]);
    constexpr const char* rows[] = {"normal", "tangent", "rotation", "stretch"};
    for (Eigen::Index m = 0; m < 4; ++m) contact += fmt::format("{},{}\n", rows[m], values(law.patch.log_N_m.row(m)));
    for (std::size_t n = 0; n < tables.surface_node.size(); ++n)
        surface += fmt::format("{},{}\n", tables.surface_node[n], tables.surface_arc_m[n]);
    std::string presses = "case," + columns("contact_", "_m", D) + ",arc_m," + columns("push_", "_m", D) + "," +
                          columns("force_", "_N", D) + ",reason\n",
                pressed = "case,node," + columns("u_", "_m", D) + "," + columns("f_", "_N", D) + "\n";
    for (const PressedCase& c : cases) {
        const std::string name = field(model.case_names[static_cast<std::size_t>(c.load_case)]);
        const std::string no_force(static_cast<std::size_t>(D - 1), ',');
        presses += fmt::format("{},{},{},{},{},{}\n", name, values(model.contact_m.row(c.load_case)), c.arc_m,
                               values(c.push_m), c.state ? values(c.state.contact_force) : no_force,
                               field(reason_of(c.state.status)));
        for (int i = 0; c.state && i < mesh.node_count(); ++i)
            pressed += fmt::format("{},{},{},{}\n", name, i, values(c.state.displacement.row(i)),
                                   values(c.force_N.row(i)));
    }
    return {{"nodes.csv", nodes_csv(model)},
            {"springs.csv", springs_csv(model, "stiffness_N_m", tables.spring_N_m)},
            {"triangles.csv", triangles_csv(mesh)},
            {"areas.csv", areas},
            {"area_edges.csv", edges},
            {"terms.csv", terms},
            {"contact.csv", contact},
            {"surface.csv", surface},
            {"presses.csv", presses},
            {"pressed.csv", pressed}};
}

Files csv_files(const Cases& cases, const std::vector<const LoadPath*>& paths) {
    const Eigen::Index D = cases.nodes.cols();
    std::string nodes = "node," + columns("", "_m", D) + "\n";
    for (Eigen::Index i = 0; i < cases.nodes.rows(); ++i)
        nodes += fmt::format("{},{}\n", i, values(cases.nodes.row(i)));
    std::string records = "path,record,magnitude_m,energy_J," + columns("contact_", "_N", D) + "," +
                          columns("support_", "_N", D) + ",smallest_J\n";
    std::string fields = "path,record,node," + columns("u_", "_m", D) + "," + columns("f_", "_N", D) + "\n";
    for (const LoadPath* path : paths)
        for (std::size_t k = 0; k < path->records.size(); ++k) {
            const PathRecord& r = path->records[k];
            const std::string which = fmt::format("{},{}", field(path->name), k);
            records += fmt::format("{},{},{},{},{},{}\n", which, r.magnitude_m, r.energy_J, values(r.contact_force_N),
                                   values(r.support_force_N), r.smallest_J);
            for (Eigen::Index i = 0; i < r.displacement.rows(); ++i)
                fields += fmt::format("{},{},{},{}\n", which, i, values(r.displacement.row(i)), values(r.force.row(i)));
        }
    return {{"nodes.csv", nodes}, {"records.csv", records}, {"fields.csv", fields}};
}

}  // namespace tissue
