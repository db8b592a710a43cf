#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "cases/cases_table.h"
#include "cases/histories_file.h"
#include "cases/load_path.h"
#include "error.h"
#include "io/one_line.h"
#include "mesh/mesh_fault.h"
#include "study/solid_study.h"
#include "version.h"

namespace tissue {
namespace {

Eigen::VectorXd single(double value) {
    return Eigen::VectorXd::Constant(1, value);
}

void write_shape(TableWriter& out, const Shape& shape) {
    std::vector<int> edges;
    if (shape.is_solid()) {
        for (const auto& facet : shape.fixed_facets) edges.insert(edges.end(), facet.begin(), facet.end());
        out.write_table("/shape/tetrahedra", shape.simplices);
        out.write_integers("/shape/region", {shape.region.size()}, shape.region);
        out.write_integers("/shape/fixed_facets", {shape.fixed_facets.size(), 3}, edges);
        if (!shape.bed.empty()) out.write_integers("/shape/bed", {shape.bed.size()}, shape.bed);
        return;
    }
    for (const auto& edge : shape.fixed_edges) edges.insert(edges.end(), edge.begin(), edge.end());
    out.write_table("/shape/triangles", shape.simplices);
    out.write_integers("/shape/region", {shape.region.size()}, shape.region);
    out.write_integers("/shape/fixed_edges", {shape.fixed_edges.size(), 2}, edges);
}

/// Refuses tetrahedra that are no valid mesh, and fixed facets that are not on its surface.
void check_fixed_facets(TableReader& in, const Shape& shape) {
    const SpringMesh mesh = edge_mesh(shape);
    if (const auto fault = mesh_fault(mesh)) in.refuse("/shape", fault->part + " " + fault->why);
    std::set<std::array<int, 3>> outside;
    const auto sorted = [](std::array<int, 3> facet) {
        std::sort(facet.begin(), facet.end());
        return facet;
    };
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) outside.insert(sorted({mesh.facets(f, 0), mesh.facets(f, 1), mesh.facets(f, 2)}));
    for (const auto& facet : shape.fixed_facets)
        if (!outside.count(sorted(facet))) in.refuse("/shape/fixed_facets", "has a facet that is not on the surface");
}

Shape read_shape(TableReader& in, const NodeField& nodes) {
    Shape shape;
    shape.nodes = nodes;
    if (nodes.cols() == 3) {
        shape.simplices = in.table_of<4>("/shape/tetrahedra");
        shape.region = in.integers("/shape/region");
        const auto facets = in.table_of<3>("/shape/fixed_facets");
        for (Eigen::Index f = 0; f < facets.rows(); ++f) shape.fixed_facets.push_back({facets(f, 0), facets(f, 1), facets(f, 2)});
        check_fixed_facets(in, shape);
        if (in.has("/shape/bed")) shape.bed = in.integers("/shape/bed");
        return shape;
    }
    shape.simplices = in.table_of<3>("/shape/triangles");
    shape.region = in.integers("/shape/region");
    const auto edges = in.table_of<2>("/shape/fixed_edges");
    for (Eigen::Index e = 0; e < edges.rows(); ++e) shape.fixed_edges.push_back({edges(e, 0), edges(e, 1)});
    if (const auto fault = triangle_fault(nodes, shape.simplices)) in.refuse("/shape/" + fault->part, fault->why);
    std::string why;
    try {
        if (const auto fault = mesh_fault(edge_mesh(shape))) why = fault->part + " " + fault->why;
    } catch (const FileError& e) {  // the outline is not one closed loop
        why = e.what();
    }
    if (!why.empty()) in.refuse("/shape", why);
    return shape;
}

void write_measurement(TableWriter& out, const Measurement& m) {
    out.write_texts("/measurement/origin", {m.origin});
    out.write_texts("/measurement/outliers", m.outliers);
    out.write("/measurement/force_noise", single(m.force_noise));
    out.write("/measurement/displacement_noise", single(m.displacement_noise_m));
    out.write_integers("/measurement/counts", {3}, {m.rows, m.contacts, m.repeats});
}

Measurement read_measurement(const Hdf5Reader& file, TableReader& in) {
    const std::vector<int> counts = in.integers("/measurement/counts");
    return {in.texts("/measurement/origin")[0], counts[0], counts[1], counts[2], in.vector("/measurement/force_noise")[0],
            in.vector("/measurement/displacement_noise")[0], file.text_attribute("/measurement", "noise_source"),
            in.texts("/measurement/outliers")};
}

/// One row for each record (R x D).
template <class Value>
NodeField rows_of(const std::vector<PathRecord>& records, Eigen::Index D, const Value& value) {
    NodeField rows(static_cast<Eigen::Index>(records.size()), D);
    for (std::size_t r = 0; r < records.size(); ++r) rows.row(static_cast<Eigen::Index>(r)) = value(records[r]).transpose();
    return rows;
}

/// One number for each record (R).
template <class Value>
Eigen::VectorXd numbers_of(const std::vector<PathRecord>& records, const Value& value) {
    Eigen::VectorXd numbers(static_cast<Eigen::Index>(records.size()));
    for (std::size_t r = 0; r < records.size(); ++r) numbers[static_cast<Eigen::Index>(r)] = value(records[r]);
    return numbers;
}

/// One nodal field for each record (R x N x D).
template <class Value>
Array fields_of(const std::vector<PathRecord>& records, const NodeField& nodes, const Value& value) {
    Array all{{records.size(), static_cast<std::size_t>(nodes.rows()), static_cast<std::size_t>(nodes.cols())}, {}};
    for (const PathRecord& r : records) {
        const NodeField& field = value(r);
        all.values.insert(all.values.end(), field.data(), field.data() + field.size());
    }
    return all;
}

void write_path(TableWriter& out, const LoadPath& path, const NodeField& nodes, bool measured) {
    const std::string group = "/paths/" + path.name + "/";
    const std::vector<PathRecord>& records = path.records;
    out.write_texts(group + "role", {path.role, path.lost});
    out.write(group + "depth", single(path.depth_m));
    if (path.radius_m > 0) out.write(group + "radius", single(path.radius_m));
    out.write(group + "contact", Eigen::VectorXd(path.contact_m));
    out.write(group + "direction", Eigen::VectorXd(path.direction));
    out.write(group + "magnitude", numbers_of(records, [](const PathRecord& r) { return r.magnitude_m; }));
    out.write(group + "contact_force", rows_of(records, path.contact_m.size(), [](const PathRecord& r) { return r.contact_force_N; }));
    if (measured) {
        out.write(group + "aside", rows_of(records, path.contact_m.size(), [](const PathRecord& r) { return r.aside_m; }));
        NodeField again(path.again_N ? 1 : 0, path.contact_m.size());
        if (path.again_N) again.row(0) = path.again_N->transpose();
        out.write(group + "again", again);
        return;
    }
    if (path.second) {
        out.write(group + "second_contact", Eigen::VectorXd(path.second->contact_m));
        out.write(group + "second_direction", Eigen::VectorXd(path.second->direction));
        out.write(group + "second_depth", single(path.second->depth_m));
        out.write(group + "second_force", rows_of(records, path.contact_m.size(), [](const PathRecord& r) { return r.second_force_N; }));
    }
    const auto u = [](const PathRecord& r) -> const NodeField& { return r.displacement; };
    const auto f = [](const PathRecord& r) -> const NodeField& { return r.force; };
    out.write(group + "displacement", fields_of(records, nodes, u));
    out.write(group + "force", fields_of(records, nodes, f));
    out.write(group + "support_force", rows_of(records, path.contact_m.size(), [](const PathRecord& r) { return r.support_force_N; }));
    out.write(group + "energy", numbers_of(records, [](const PathRecord& r) { return r.energy_J; }));
    out.write(group + "smallest_J", numbers_of(records, [](const PathRecord& r) { return r.smallest_J; }));
    out.write(group + "newton_residual", numbers_of(records, [](const PathRecord& r) { return r.newton_residual; }));
    std::vector<int> newton;
    for (const PathRecord& r : records) newton.push_back(r.newton_iterations);
    out.write_integers(group + "newton_iterations", {records.size()}, newton);
}

/// in: a copy for this path alone, because the number of records R differs between paths.
LoadPath read_path(TableReader in, const std::string& name, const NodeField& nodes, bool measured) {
    const std::string group = "/paths/" + name + "/";
    LoadPath path;
    path.name = name;
    const std::vector<std::string> role = in.texts(group + "role");
    path.role = role[0];
    path.lost = one_line(role[1]);
    path.depth_m = in.vector(group + "depth")[0];
    if (in.has(group + "radius")) path.radius_m = in.vector(group + "radius")[0];
    path.contact_m = in.vector(group + "contact");
    path.direction = in.vector(group + "direction");
    const Eigen::VectorXd magnitude = in.vector(group + "magnitude");
    if (magnitude.size() > 0 && magnitude.maxCoeff() > size_m(nodes))
        in.refuse(group + "magnitude", fmt::format("goes to {:.3g} mm, beyond the tissue's size of {:.3g} mm", 1e3 * magnitude.maxCoeff(), 1e3 * size_m(nodes)));
    const NodeField contact = in.field(group + "contact_force");
    if (measured) {
        const NodeField aside = in.field(group + "aside"), again = in.field(group + "again");
        for (Eigen::Index r = 0; r < magnitude.size(); ++r)
            path.records.push_back(measured_record(magnitude[r], contact.row(r).transpose(), aside.row(r).transpose()));
        if (again.rows() > 1) in.refuse(group + "again", "has more than one row");
        if (again.rows() == 1) path.again_N = again.row(0).transpose();
        return path;
    }
    NodeField second;
    constexpr const char* of_second[] = {"second_contact", "second_direction", "second_depth", "second_force"};
    if (std::any_of(std::begin(of_second), std::end(of_second), [&](const char* of) { return in.has(group + of); })) {
        path.second = SecondTool{in.vector(group + "second_contact"), in.vector(group + "second_direction"), in.vector(group + "second_depth")[0]};
        second = in.field(group + "second_force");
        const double deepest_m = magnitude.size() > 0 ? magnitude.maxCoeff() * path.second->depth_m / path.depth_m : 0;
        if (deepest_m > size_m(nodes)) in.refuse(group + "second_depth", fmt::format("moves the second disc by {:.3g} mm, beyond the tissue's size of {:.3g} mm", 1e3 * deepest_m, 1e3 * size_m(nodes)));
    }
    const Eigen::VectorXd energy = in.vector(group + "energy"), J = in.vector(group + "smallest_J"),
                          residual = in.vector(group + "newton_residual");
    const NodeField support = in.field(group + "support_force");
    const Array u = in.array(group + "displacement"), f = in.array(group + "force");
    const std::vector<int> newton = in.integers(group + "newton_iterations");
    for (Eigen::Index r = 0; r < magnitude.size(); ++r) {
        const auto at = [&](const Array& a) {
            return Eigen::Map<const NodeField>(a.values.data() + r * nodes.size(), nodes.rows(), nodes.cols());
        };
        path.records.push_back({magnitude[r], at(u), at(f), contact.row(r).transpose(), support.row(r).transpose(), energy[r], J[r],
                                newton[static_cast<std::size_t>(r)], residual[r]});
        if (path.second) path.records.back().second_force_N = second.row(r).transpose();
    }
    return path;
}

}  // namespace

const DatasetTable& cases_table(bool measured) {
    static const DatasetTable all = {
        {"/nodes", "N x D", Values::place(), "m", "nodes at rest, where displacements are compared", Rows::distinct},
        {"/shape/triangles", "T x 3", Values::index("N"), "1", "triangles between the nodes", Rows::distinct},
        {"/shape/tetrahedra", "T x 4", Values::index("N"), "1", "in space: tetrahedra between the nodes", Rows::distinct},
        {"/shape/fixed_facets", "B x 3", Values::index("N"), "1", "in space: fixed facets of the surface", Rows::distinct},
        {"/shape/bed", "B", Values::count(), "1", "where fixed parts are on elastic beds: number of each fixed facet's bed, from 1; 0: it does not move"},
        {"/shape/region", "T", Values::count(), "1", "0: base material, else 1 + named region"},
        {"/shape/fixed_edges", "B x 2", Values::index("N"), "1", "fixed edges of the outline", Rows::distinct},
        {"/magnitudes", "M*", Values::positive(), "m", "tool displacements that are load cases", Rows::ascending},
        {"/path_names", "P", Values::names(), "text", "load paths in the study's order"},
        {"/paths/NAME/role", "2", Values::text(), "text", "role of the path, and why FE ended early, if so"},
        {"/paths/NAME/depth", "1", Values::positive(), "m", "largest tool displacement planned"},
        {"/paths/NAME/radius", "1", Values::positive(), "m", "radius of the disc, where it is not the study's own"},
        {"/paths/NAME/contact", "D", Values::place(), "m", "contact at rest"},
        {"/paths/NAME/direction", "D", Values::finite(), "1", "unit vector of the tool displacement", Rows::unit},
        {"/paths/NAME/magnitude", "R*", Values::not_negative(), "m", "tool displacement", Rows::ascending},
        {"/paths/NAME/contact_force", "R* x D", Values::finite(), "N", "force of the indenter on the tissue"},
    };
    static const DatasetTable fe = joined(all, {
        {"/paths/NAME/displacement", "R* x N x D", Values::finite(), "m", "u at the nodes"},
        {"/paths/NAME/force", "R* x N x D", Values::finite(), "N", "external nodal force in equilibrium with u, lumped to the nodes"},
        {"/paths/NAME/support_force", "R* x D", Values::finite(), "N", "force of the supports on the tissue"},
        {"/paths/NAME/energy", "R*", Values::finite(), "J", "elastic energy"},
        {"/paths/NAME/smallest_J", "R*", Values::positive(), "1", "smallest det F in the tissue"},
        {"/paths/NAME/newton_residual", "R*", Values::not_negative(), "1", "largest free force over largest reaction"},
        {"/paths/NAME/second_contact", "D", Values::place(), "m", "contact at rest of a second disc that indents at once"},
        {"/paths/NAME/second_direction", "D", Values::finite(), "1", "unit vector of its displacement", Rows::unit},
        {"/paths/NAME/second_depth", "1", Values::positive(), "m", "its largest displacement planned; it is displaced in proportion"},
        {"/paths/NAME/second_force", "R* x D", Values::finite(), "N", "force of that disc on the tissue"},
        {"/paths/NAME/newton_iterations", "R*", Values::count(), "1", "Newton iterations since the record before"},
    });
    static const DatasetTable hand = joined(all, {
        {"/measurement/origin", "1", Values::text(), "text", "comments at the head of the measured data"},
        {"/measurement/outliers", "O*", Values::text(), "text", "rows that differ from their repeats; they are kept"},
        {"/measurement/force_noise", "1", Values::not_negative(), "1",
         "standard deviation of a component of the force, relative to the force"},
        {"/measurement/displacement_noise", "1", Values::not_negative(), "m", "standard deviation of a component of the displacement"},
        {"/measurement/counts", "3", Values::count(), "1", "rows, contacts, degrees of freedom of the noise"},
        {"/paths/NAME/aside", "R* x D", Values::finite(), "m", "part of the tool displacement across the direction"},
        {"/paths/NAME/again", "A* x D", Values::finite(), "N",
         "mean contact force of the repeats of the measurement, A = 0 or 1"},
    });
    return measured ? hand : fe;
}

void write_cases(const std::string& file, const Cases& cases, const Provenance& provenance) {
    const bool measured = cases.measurement.has_value();
    const bool solid = cases.nodes.cols() == 3;
    const bool pairs = std::any_of(cases.paths.begin(), cases.paths.end(), [](const LoadPath& path) { return path.second.has_value(); });
    const int version_of_format = pairs ? two_tools_format_version : cases.disc_radius_m > 0 ? radii_format_version : !cases.histories.empty() ? time_format_version : solid ? solid_format_version : format_version;
    Hdf5Writer hdf5(file, "cases", provenance, version_of_format);
    hdf5.attribute("/", "study", cases.study);
    if (solid) hdf5.attribute("/", "dimension", 3);
    if (cases.disc_radius_m > 0) hdf5.attribute("/", "disc_radius_m", cases.disc_radius_m);
    TableWriter out(hdf5, cases_table(measured));
    out.write("/nodes", cases.nodes);
    if (cases.shape) write_shape(out, *cases.shape);
    out.write("/magnitudes", Array{{cases.magnitudes_m.size()}, cases.magnitudes_m});
    std::vector<std::string> names;
    for (const LoadPath& path : cases.paths) names.push_back(path.name);
    out.write_texts("/path_names", names);
    if (measured) {
        write_measurement(out, *cases.measurement);
        hdf5.attribute("/measurement", "noise_source", cases.measurement->noise_source);
    }
    for (const LoadPath& path : cases.paths) write_path(out, path, cases.nodes, measured);
    TableWriter in_time(hdf5, histories_table());
    if (!cases.histories.empty()) write_histories(in_time, cases.histories, cases.nodes.cols());
    hdf5.commit();
}

namespace {

/// The radius of the study's own disc; 0 where the file has none, because all paths have this disc.
double disc_radius_of(const Hdf5Reader& file) {
    if (!file.has_attribute("/", "disc_radius_m")) return 0;
    const double radius_m = file.number_attribute("/", "disc_radius_m");
    if (!(radius_m > 0 && radius_m < 1e3)) file.refuse("/", fmt::format("attribute 'disc_radius_m' is {}, must be a number > 0", radius_m));
    return radius_m;
}

/// 2 where the file has no such attribute.
int dimension_of(const Hdf5Reader& file) {
    if (!file.has_attribute("/", "dimension")) return 2;
    const double D = file.number_attribute("/", "dimension");
    if (D != 2 && D != 3) file.refuse("/", fmt::format("attribute 'dimension' is {}, must be 2 or 3", D));
    return static_cast<int>(D);
}

}  // namespace

Cases read_cases(const std::string& name) {
    const Hdf5Reader file(name, "cases");
    Cases cases;
    cases.study = file.text_attribute("/", "study");
    const bool measured = file.has("/measurement");
    const int D = dimension_of(file);
    for (const char* group : {"/measurement", "/shape/triangles"})
        if (D == 3 && file.has(group)) file.refuse(group, "is for cases in the plane, and these cases have 3 dimensions");
    TableReader in(file, cases_table(measured), {{"D", D}});
    cases.nodes = in.field("/nodes");
    if (file.has("/shape")) cases.shape = read_shape(in, cases.nodes);
    const Eigen::VectorXd magnitudes = in.vector("/magnitudes");
    cases.magnitudes_m.assign(magnitudes.begin(), magnitudes.end());
    if (measured) cases.measurement = read_measurement(file, in);
    cases.disc_radius_m = D == 3 ? disc_radius_of(file) : 0;
    for (const std::string& path : in.texts("/path_names")) {
        cases.paths.push_back(read_path(in, path, cases.nodes, measured));
        if (cases.paths.back().second && D == 2) file.refuse("/paths/" + path + "/second_contact", "is for cases in space, and these cases are in the plane");
        if (cases.paths.back().second && !is_role_of_pairs(cases.paths.back().role))
            file.refuse("/paths/" + path + "/second_contact", fmt::format("is in a path of role '{}', which has one disc", cases.paths.back().role));
        if (cases.paths.back().radius_m > 0 && cases.disc_radius_m == 0) file.refuse("/paths/" + path + "/radius", "is in a file without attribute 'disc_radius_m'");
    }
    std::map<std::string, const LoadPath*> first_of;  // first path of each role: all have one disc, or all have two
    for (const LoadPath& path : cases.paths) {
        const LoadPath& first = *first_of.emplace(path.role, &path).first->second;
        if (path.second.has_value() != first.second.has_value())
            file.refuse("/paths/" + path.name, fmt::format("has the same role as '{}', but only one of the two has two discs", first.name));
    }
    if (file.has("/histories")) {
        TableReader in_time(file, histories_table(), {{"D", D}});
        cases.histories = read_histories(in_time);
    }
    return cases;
}

}  // namespace tissue
