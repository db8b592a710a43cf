#include "export/csv.h"

#include <fmt/format.h>

#include <algorithm>

#include "export/solid_model_tables.h"

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

/// Quoted where it contains a comma, a quote or a line feed.
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

/// springs.csv, with a last column of one stiffness that serves all cases.
std::string springs_csv(const TissueModel& model, const std::string& name, const Eigen::VectorXd& theta) {
    const SpringMesh& mesh = model.mesh;
    std::string springs = "spring,node_i,node_j,rest_length_m,heuristic_a_N_m,heuristic_b_N_m," + name + "\n";
    for (int s = 0; s < mesh.spring_count(); ++s)
        springs += fmt::format("{},{},{},{},{},{},{}\n", s, mesh.springs(s, 0), mesh.springs(s, 1), mesh.rest_length(s),
                               model.heuristic_a[s], model.heuristic_b[s], theta[s]);
    return springs;
}

/// Node numbers, one row per element.
std::string nodes_of_csv(const Cells& cells) {
    constexpr const char* letters = "ijkl";
    std::string text;
    for (Eigen::Index k = 0; k < cells.cols(); ++k) text += fmt::format("{}node_{}", k > 0 ? "," : "", letters[k]);
    text += '\n';
    for (Eigen::Index t = 0; t < cells.rows(); ++t) text += values(cells.row(t)) + "\n";
    return text;
}

/// The simplices of the tissue: triangles; in space tetrahedra, and the facets of the surface.
Files simplices_csv(const SpringMesh& mesh) {
    if (!mesh.is_solid()) return {{"triangles.csv", nodes_of_csv(mesh.simplices)}};
    return {{"tetrahedra.csv", nodes_of_csv(mesh.simplices)}, {"facets.csv", nodes_of_csv(mesh.facets)}};
}

std::string terms_csv(const EnergyModel& energy_model) {
    std::string terms = "term,coefficient\n";
    for (std::size_t t = 0; t < energy_model.terms.size(); ++t)
        terms += fmt::format("{},{}\n", field(energy_model.terms[t]), energy_model.coefficients[static_cast<Eigen::Index>(t)]);
    return terms;
}

std::string contact_csv(const SpringMesh& mesh, const EnergyModel& energy_model, const std::vector<std::string>& rows) {
    const ContactParameters& patch = energy_model.patch;
    std::string contact = fmt::format("row,log_k_N_m,{},{},edge\n", mesh.is_solid() ? "curved" : "phase", patch.hardens() ? "ground" : "corner");
    for (std::size_t m = 0; m < rows.size(); ++m)
        contact += fmt::format("{},{}\n", rows[m], values(patch.log_N_m.row(static_cast<Eigen::Index>(m))));
    if (const Eigen::Vector2d& range = energy_model.disc.curved_range; std::isfinite(range[0])) contact += fmt::format("least,,{},,\nmost,,{},,\n", range[0], range[1]);
    return contact;
}

Files pressed_csv(const TissueModel& model, const std::vector<IndentationOfCase>& cases) {
    const int D = model.mesh.dimension();
    const bool solid = model.mesh.is_solid();
    std::string presses = "case," + columns("contact_", "_m", D) + (solid ? ",radius_m," : ",arc_m,") + columns("push_", "_m", D) + "," +
                          columns("force_", "_N", D) + ",reason\n",
                pressed = "case,node," + columns("u_", "_m", D) + "," + columns("f_", "_N", D) + "\n";
    const std::string no_force(static_cast<std::size_t>(D - 1), ',');
    for (const IndentationOfCase& c : cases) {
        const std::string name = field(model.case_names[static_cast<std::size_t>(c.load_case)]);
        const double disc_m = model.radius_of(c.load_case);
        presses += fmt::format("{},{},{}{},{},{}\n", name, values(model.contact_m.row(c.load_case)),
                               fmt::format("{},", c.arc_m ? *c.arc_m : disc_m > 0 ? disc_m : model.energy_model->disc_radius_m), values(c.push_m),
                               c.state ? values(c.state.contact_force) : no_force, field(reason_of(c.state.status)));
        for (int i = 0; c.state && i < model.mesh.node_count(); ++i)
            pressed += fmt::format("{},{},{},{}\n", name, i, values(c.state.displacement.row(i)), values(c.force_N.row(i)));
    }
    return {{"presses.csv", presses}, {"pressed.csv", pressed}};
}

/// Rows of correction.csv for one disc, at the points of each facet where the correction is stored.
std::string correction_rows(double radius_m, const FacetTable& correction) {
    std::string rows;
    if (correction.value.rows() == 0) return rows;
    const NodeField at = FacetTable::corners(FacetTable::parts_of(correction.value.cols()));
    for (Eigen::Index f = 0; f < correction.value.rows(); ++f)
        for (Eigen::Index v = 0; v < at.rows(); ++v) rows += fmt::format("{},{},{},{}\n", radius_m, f, values(at.row(v)), correction.value(f, v));
    return rows;
}

/// Tables of an energy model in space only.
Files solid_csv(const TissueModel& model, const std::vector<IndentationOfCase>& cases) {
    const SolidModelTables tables = solid_model_tables(model);
    std::vector<int> load_cases;
    for (const IndentationOfCase& c : cases) load_cases.push_back(c.load_case);
    const ContactTable contact = contact_table(model, load_cases);
    const std::string corners = "node_000,node_100,node_010,node_110,node_001,node_101,node_011,node_111";
    std::string cells = "cell," + corners + ",at_x,at_y,at_z,rest_volume_m3,stiffness_Pa\n";
    for (Eigen::Index c = 0; c < tables.cells.rows(); ++c)
        cells += fmt::format("{},{},{},{},{}\n", c, values(tables.cells.row(c)), values(tables.at.row(c)), tables.volume_m3[c], tables.cell_Pa[c]);
    const auto name = [&](int load_case) { return field(model.case_names[static_cast<std::size_t>(load_case)]); };
    std::string rows = "row,case,kind,k_N_m,push_x,push_y,push_z\n", pull = "row,node,pull_x,pull_y,pull_z\n",
                hardening = "case,hardening_1_J,saturation_1_J,coupling_N_m2,in_compression\n";
    for (std::size_t r = 0; r < contact.k_N_m.size(); ++r)
        rows += fmt::format("{},{},{},{},{}\n", r, name(contact.load_case[r]), contact.kind[r], contact.k_N_m[r],
                            values(contact.push.row(static_cast<Eigen::Index>(r))));
    for (std::size_t q = 0; q < contact.pull_row.size(); ++q)
        pull += fmt::format("{},{},{}\n", contact.pull_row[q], contact.pull_node[q], values(contact.pull.row(static_cast<Eigen::Index>(q))));
    for (std::size_t c = 0; c < load_cases.size(); ++c)
        hardening += fmt::format("{},{}\n", name(load_cases[c]), values(contact.hardening.row(static_cast<Eigen::Index>(c))));
    Files files = {{"springs.csv", springs_csv(model, "stiffness_N_m", tables.spring_N_m)},
            {"cells.csv", cells},
            {"contact.csv", contact_csv(model.mesh, *model.energy_model, {"normal", "tangent", "imprint_normal", "imprint_tangent", "hardening", "saturation", "coupling"})},
            {"contact_rows.csv", rows},
            {"contact_pull.csv", pull},
            {"contact_hardening.csv", hardening}};
    const Embedding& embedding = model.mesh.embedding;
    std::string& inside = files["embedding.csv"] = "node," + corners + ",weight_000,weight_100,weight_010,weight_110,weight_001,weight_101,weight_011,weight_111\n";
    for (int node = 0; node < embedding.node_count(); ++node) inside += fmt::format("{},{},{}\n", node, values(embedding.corner.row(node)), values(embedding.weight.row(node)));
    const EnergyModel& energy_model = *model.energy_model;
    files["correction.csv"] = "radius_m,facet,weight_i,weight_j,weight_k,log_scale\n" + correction_rows(energy_model.disc_radius_m, energy_model.disc.correction);
    for (std::size_t k = 0; k < energy_model.sizes.correction.size(); ++k)
        if (const double radius_m = energy_model.sizes.radii_m[static_cast<Eigen::Index>(k)]; radius_m != energy_model.disc_radius_m) files["correction.csv"] += correction_rows(radius_m, energy_model.sizes.correction[k]);
    if (energy_model.contact_log_scale.size() > 0) {
        std::string& surface = files["surface.csv"] = "node,contact_log_scale\n";
        for (Eigen::Index node = 0; node < energy_model.contact_log_scale.size(); ++node) surface += fmt::format("{},{}\n", node, energy_model.contact_log_scale[node]);
    }
    std::string& supports = files["supports.csv"] = "node,stiffness_N_m\n";
    for (Eigen::Index m = 0; m < tables.support_N_m.size(); ++m) supports += fmt::format("{},{}\n", model.mesh.fixed[static_cast<std::size_t>(m)], tables.support_N_m[m]);
    return files;
}

/// Tables of an energy model in the plane only.
Files plane_csv(const TissueModel& model) {
    const EnergyModelTables tables = energy_model_tables(model);
    std::string areas = "area,kind,rest_area_m2,stiffness_N_m\n", edges = "area,node_i,node_j\n", surface = "node,arc_m,contact_log_scale\n";
    for (std::size_t e = 0; e < tables.area_kind.size(); ++e) {
        const auto i = static_cast<Eigen::Index>(e);
        areas += fmt::format("{},{},{},{}\n", e, tables.area_kind[e], tables.area_m2[i], tables.area_N_m[i]);
    }
    for (std::size_t k = 0; k < tables.edge_area.size(); ++k)
        edges += fmt::format("{},{},{}\n", tables.edge_area[k], tables.edge_from[k], tables.edge_to[k]);
    for (std::size_t n = 0; n < tables.surface_node.size(); ++n)
        surface += fmt::format("{},{},{}\n", tables.surface_node[n], tables.surface_arc_m[n], tables.surface_log_scale[n]);
    return {{"springs.csv", springs_csv(model, "stiffness_N_m", tables.spring_N_m)},
            {"areas.csv", areas},
            {"area_edges.csv", edges},
            {"contact.csv", contact_csv(model.mesh, *model.energy_model, {"normal", "tangent", "rotation", "stretch"})},
            {"surface.csv", surface}};
}

/// For springs that are not Hooke's.
Files curve_csv(const SpringCurve& curve) {
    if (curve.hookean()) return {};
    return {{"spring_curve.csv", fmt::format("c2_share,straight_below,straight_above\n{},{},{}\n", curve.q(), curve.shorter().stretch, curve.longer().stretch)}};
}

/// For an energy model that relaxes.
Files relaxation_csv(const Relaxation& relaxation) {
    if (relaxation.empty()) return {};
    std::string branches = "branch,relaxation_time_s,contact_share\n", shares = "constant";
    for (Eigen::Index k = 0; k < relaxation.branches(); ++k) {
        branches += fmt::format("{},{},{}\n", k, relaxation.tau_s[k], relaxation.contact_share[k]);
        shares += fmt::format(",share_{}", k);
    }
    shares += '\n';
    for (Eigen::Index e = 0; e < relaxation.share.rows(); ++e) shares += fmt::format("{},{}\n", e, values(relaxation.share.row(e)));
    return {{"branches.csv", branches}, {"shares.csv", shares}};
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
    Files files = {{"nodes.csv", nodes_csv(model)},
                   {"springs.csv", springs_csv(model, "one_set_N_m", model.one_set)},
                   {"sets.csv", table},
                   {"stiffness.csv", stiffness}};
    files.merge(simplices_csv(mesh));
    return files;
}

Files csv_files(const TissueModel& model, const std::vector<IndentationOfCase>& cases) {
    Files files = {{"nodes.csv", nodes_csv(model)}, {"terms.csv", terms_csv(*model.energy_model)}};
    files.merge(simplices_csv(model.mesh));
    files.merge(pressed_csv(model, cases));
    files.merge(relaxation_csv(model.energy_model->relaxation));
    files.merge(curve_csv(model.energy_model->curve));
    files.merge(model.mesh.is_solid() ? solid_csv(model, cases) : plane_csv(model));
    return files;
}

Files csv_files(const Cases& cases, const std::vector<const LoadPath*>& paths) {
    const Eigen::Index D = cases.nodes.cols();
    std::string nodes = "node," + columns("", "_m", D) + "\n";
    for (Eigen::Index i = 0; i < cases.nodes.rows(); ++i)
        nodes += fmt::format("{},{}\n", i, values(cases.nodes.row(i)));
    const bool with_pairs = std::any_of(paths.begin(), paths.end(), [](const LoadPath* path) { return path->second.has_value(); });
    std::string records = "path,record,magnitude_m,energy_J," + columns("contact_", "_N", D) + "," +
                          columns("support_", "_N", D) + ",smallest_J" + (with_pairs ? "," + columns("second_", "_N", D) : "") + "\n";
    std::string fields = "path,record,node," + columns("u_", "_m", D) + "," + columns("f_", "_N", D) + "\n";
    for (const LoadPath* path : paths)
        for (std::size_t k = 0; k < path->records.size(); ++k) {
            const PathRecord& r = path->records[k];
            const std::string which = fmt::format("{},{}", field(path->name), k);
            const bool measured = r.displacement.size() == 0;  // then energy, support force and strain are not known
            const std::string unknown(static_cast<std::size_t>(D - 1), ',');
            records += fmt::format("{},{},{},{},{},{}", which, r.magnitude_m, measured ? "" : fmt::format("{}", r.energy_J), values(r.contact_force_N),
                                   measured ? unknown : values(r.support_force_N), measured ? "" : fmt::format("{}", r.smallest_J));
            if (with_pairs) records += "," + (path->second ? values(r.second_force_N) : unknown);
            records += '\n';
            for (Eigen::Index i = 0; i < r.displacement.rows(); ++i)
                fields += fmt::format("{},{},{},{}\n", which, i, values(r.displacement.row(i)), values(r.force.row(i)));
        }
    return {{"nodes.csv", nodes}, {"records.csv", records}, {"fields.csv", fields}};
}

}  // namespace tissue
