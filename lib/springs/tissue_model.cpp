#include "springs/tissue_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "error.h"
#include "mesh/cube_search.h"
#include "mesh/mesh_fault.h"
#include "mesh/topology.h"
#include "springs/cell_volumes.h"
#include "springs/energy_model_file.h"
#include "springs/spring_law.h"
#include "springs/tissue_table.h"
#include "version.h"

namespace tissue {
namespace {

/// Dataset names of the mesh geometry, by dimension.
struct MeshNames {
    const char *simplices, *incident_measure, *node_measure;
};
const MeshNames& names_of(bool solid) {
    static const MeshNames plane = {"/mesh/triangles", "/mesh/incident_area", "/mesh/node_area"},
                           space = {"/mesh/tetrahedra", "/mesh/incident_volume", "/mesh/node_volume"};
    return solid ? space : plane;
}

}  // namespace

const DatasetTable& tissue_table(bool solid) {
    static const DatasetTable all = {
        {"/mesh/nodes", "N x D", Values::place(), "m", "nodes at rest; of an embedded solid its own, then its lattice's, which may have the same places"},
        {"/mesh/springs", "S x 2", Values::index("N"), "1", "node pair of each spring", Rows::distinct},
    };
    static const DatasetTable rest = {
        {"/mesh/fixed", "F", Values::index("N"), "1", "fixed nodes", Rows::ascending},
        {"/node_mass", "N", Values::not_negative(), "kg", "node masses, (8); 0 of an embedded solid's own nodes, and of no others"},
        {"/cases/names", "C", Values::names(), "text", "training load cases"},
        {"/cases/contact", "C x D", Values::place(), "m", "contact at rest"},
        {"/cases/direction", "C x D", Values::finite(), "1", "unit vector of the tool displacement", Rows::unit},
        {"/cases/magnitude", "C", Values::positive(), "m", "tool displacement"},
        {"/cases/contact_force", "C x D", Values::finite(), "N", "FE force of the indenter on the tissue", Rows::any, true},
    };
    static const DatasetTable plane = joined(joined(all, {
        {"/mesh/triangles", "T x 3", Values::index("N"), "1", "triangulation for drawing", Rows::distinct},
        {"/mesh/boundary", "M", Values::index("N"), "1", "nodes of the outline, counter-clockwise", Rows::distinct},
        {"/mesh/incident_area", "S", Values::positive(), "m2", "sum of area(T_e) in (7)"},
        {"/mesh/node_area", "N", Values::positive(), "m2", "tissue area that a node carries, (8)"},
        {"/heuristic_a", "S", Values::positive(), "N/m", "theta of (7), E2 = E t"},
        {"/heuristic_b", "S", Values::positive(), "N/m", "theta of (7), E2 = (C1 + C2) t"},
    }), rest);
    static const DatasetTable space = joined(joined(all, {
        {"/cases/radius", "C", Values::positive(), "m", "radius of the disc, if load cases have several", Rows::any, true},
        {"/mesh/tetrahedra", "T x 4", Values::index("N"), "1", "tetrahedra of the tissue, of positive volume", Rows::distinct},
        {"/mesh/facets", "B x 3", Values::index("N"), "1", "triangles of its surface, normals out", Rows::distinct},
        {"/mesh/incident_volume", "S", Values::positive(), "m3", "sum in (7), of volumes (mesh/embedded_lattice.h)"},
        {"/mesh/node_volume", "N", Values::not_negative(), "m3", "tissue volume that a node carries, (8); 0 of an embedded solid's own nodes"},
        {"/mesh/lattice/cubes", "Q x 8", Values::index("N"), "1", "of an embedded solid: corners of each cube of its lattice; bits of a corner: 1 along x, 2 along y, 4 along z", Rows::any, true},
        {"/mesh/lattice/fraction", "Q", Values::positive(), "1", "part of a cube's volume that is tissue", Rows::any, true},
        {"/mesh/lattice/centroid", "Q x 3", Values::not_negative(), "1", "centroid of that tissue, from corner 0 in edges", Rows::any, true},
        {"/mesh/lattice/corner", "K x 8", Values::index("N"), "1", "corners from which each of the solid's own nodes, the first K, is interpolated", Rows::any, true},
        {"/mesh/lattice/weight", "K x 8", Values::finite(), "1", "weights of these corners, sum 1", Rows::any, true},
        {"/nodule/points", "V x 3", Values::place(), "m", "points of the surface of a part of other material, at rest", Rows::any, true},
        {"/nodule/triangles", "W x 3", Values::index("V"), "1", "triangles of this surface, normals out", Rows::distinct, true},
        {"/heuristic_a", "S", Values::positive(), "N/m", "theta of (7), with E in place of E2"},
        {"/heuristic_b", "S", Values::positive(), "N/m", "theta of (7), with C1 + C2 in place of E2"},
    }), rest);
    return solid ? space : plane;
}

const DatasetTable& sets_table() {
    static const DatasetTable table = {
        {"/one_set", "S", Values::not_negative(), "N/m", "the single set with the least loss over all cases"},
        {"/optimum/theta", "C x S", Values::not_negative(), "N/m", "certified optimum in the box"},
        {"/optimizers", "O", Values::names(), "text", "groups of /trained, that of the study's optimiser first"},
        {"/trained/NAME/theta", "C x S", Values::not_negative(), "N/m", "trained spring sets"},
    };
    return table;
}

namespace {

void write_sets(Hdf5Writer& file, const TissueModel& model) {
    TableWriter out(file, sets_table());
    out.write("/one_set", model.one_set);
    out.write("/optimum/theta", model.optimum);
    std::vector<std::string> optimizers;
    for (const SpringSets& sets : model.trained) {
        out.write("/trained/" + sets.optimizer + "/theta", sets.theta);
        optimizers.push_back(sets.optimizer);
    }
    out.write_texts("/optimizers", optimizers);
}

/// in: reader of the mesh's tables, with their lengths.
void read_sets(TableReader in, TissueModel& model) {
    in.use(sets_table());
    model.one_set = in.vector("/one_set");
    model.optimum = in.field("/optimum/theta");
    for (const std::string& optimizer : in.texts("/optimizers"))
        model.trained.push_back({optimizer, in.field("/trained/" + optimizer + "/theta")});
}

/// Refuses two nodes at the same position. A node of an embedded solid and one of its lattice may coincide.
void refuse_twins(const TableReader& in, const SpringMesh& mesh) {
    std::set<std::vector<double>> places;
    for (int node = 0; node < mesh.node_count(); ++node) {
        if (node == mesh.embedding.node_count()) places.clear();
        if (!places.insert({mesh.nodes.row(node).begin(), mesh.nodes.row(node).end()}).second) in.refuse("/mesh/nodes", fmt::format("row {} is present twice", node));
    }
}

/// in: reader of the mesh's tables; springs and fixed nodes are already read.
void read_embedding(const Hdf5Reader& file, TableReader& in, SpringMesh& mesh) {
    if (in.has("/mesh/lattice/cubes") != (mesh.topology == "embedded")) in.refuse("/mesh", "topology '" + mesh.topology + "' and a group 'lattice' do not belong together");
    if (mesh.topology != "embedded") return;
    Embedding& e = mesh.embedding;
    e.cubes = in.field("/mesh/lattice/cubes").cast<int>();
    e.fraction = in.vector("/mesh/lattice/fraction");
    e.centroid = in.field("/mesh/lattice/centroid");
    e.corner = in.field("/mesh/lattice/corner").cast<int>();
    e.weight = in.field("/mesh/lattice/weight");
    e.spacing_m = file.number_attribute("/mesh/lattice", "spacing_m");
    if (!(e.spacing_m > 0 && e.spacing_m < 1e3)) in.refuse("/mesh/lattice", fmt::format("attribute 'spacing_m' is {}, must be a number > 0", e.spacing_m));
    const int K = e.node_count();
    if (!(e.fraction.maxCoeff() <= 1 + 1e-9)) in.refuse("/mesh/lattice/fraction", "is above 1");
    if (!(e.centroid.maxCoeff() <= 1 + 1e-9)) in.refuse("/mesh/lattice/centroid", "is above 1");
    if (!((e.weight.rowwise().sum().array() - 1).abs().maxCoeff() < 1e-9) || !(e.weight.cwiseAbs().maxCoeff() < 100)) in.refuse("/mesh/lattice/weight", "does not sum to 1 in each row");
    const auto lattice = [&](const std::string& name, int least) {
        if (least < K) in.refuse(name, fmt::format("names node {}, which is the solid's own and not the lattice's", least));
    };
    lattice("/mesh/lattice/cubes", e.cubes.minCoeff());
    lattice("/mesh/lattice/corner", e.corner.minCoeff());
    lattice("/mesh/springs", mesh.springs.minCoeff());
    std::vector<bool> cornered(static_cast<std::size_t>(mesh.node_count()), false);
    for (int node : e.cubes.reshaped()) cornered[static_cast<std::size_t>(node)] = true;
    const auto alone = std::find(cornered.begin() + K, cornered.end(), false);
    if (alone != cornered.end()) in.refuse("/mesh/lattice/cubes", fmt::format("do not use node {} of the lattice", alone - cornered.begin()));
    if (mesh.simplices.maxCoeff() >= K) in.refuse("/mesh/tetrahedra", "include a node of the lattice");
    if (!mesh.fixed.empty() && mesh.fixed.back() >= K) in.refuse("/mesh/fixed", fmt::format("names node {}, which is the lattice's and not the solid's own", mesh.fixed.back()));
    try {
        CellVolumes{mesh};
        CubeSearch(mesh.nodes, e.cubes, e.spacing_m);
    } catch (const MismatchError& error) {
        in.refuse("/mesh/lattice/cubes", error.what());
    }
}

/// Reads the inclusion's surface. Its points must lie within the solid's bounding box, or 10 % of the solid's size
/// outside it: the mesh may be coarser than the surface in which the study places the inclusion.
NoduleSurface read_nodule(TableReader& in, const SpringMesh& mesh) {
    if (in.has("/nodule/points") != in.has("/nodule/triangles")) in.refuse("/nodule", "needs both points and triangles");
    if (!in.has("/nodule/points")) return {};
    NoduleSurface nodule{in.field("/nodule/points"), in.field("/nodule/triangles").cast<int>()};
    if (nodule.points.rows() > most_nodule_points) in.refuse("/nodule/points", fmt::format("has {} points; at most {} are possible", nodule.points.rows(), most_nodule_points));
    if (const auto why = nodule_fault(nodule)) in.refuse("/nodule/triangles", *why);
    const NodeField own = mesh.own_nodes();
    const double beyond_m = 0.1 * mesh.size_m();
    const Eigen::RowVectorXd low = own.colwise().minCoeff().array() - beyond_m, high = own.colwise().maxCoeff().array() + beyond_m;
    for (Eigen::Index v = 0; v < nodule.points.rows(); ++v)
        if ((nodule.points.row(v).array() < low.array()).any() || (nodule.points.row(v).array() > high.array()).any())
            in.refuse("/nodule/points", fmt::format("point {} is outside the tissue", v));
    return nodule;
}

}  // namespace

void write_tissue(Hdf5Writer& file, const TissueModel& model) {
    file.attribute("/", "study", model.study);
    file.attribute("/", "law", model.law);
    file.attribute("/", "topology", model.mesh.topology);
    file.attribute("/", "modulus_N_m", model.modulus_N_m);
    const bool solid = model.mesh.is_solid();
    const MeshNames& names = names_of(solid);
    if (solid) file.attribute("/", "dimension", 3.0);
    TableWriter out(file, tissue_table(solid));
    out.write("/mesh/nodes", model.mesh.nodes);
    out.write_table("/mesh/springs", model.mesh.springs);
    out.write_table(names.simplices, model.mesh.simplices);
    if (solid)
        out.write_table("/mesh/facets", model.mesh.facets);
    else
        out.write_integers("/mesh/boundary", {static_cast<std::size_t>(model.mesh.facets.rows())}, model.mesh.loop());
    out.write_integers("/mesh/fixed", {model.mesh.fixed.size()}, model.mesh.fixed);
    out.write(names.incident_measure, model.mesh.incident_measure);
    out.write(names.node_measure, model.mesh.node_measure);
    out.write("/node_mass", model.node_mass_kg);
    if (const Embedding& e = model.mesh.embedding; !e.empty()) {
        out.write_table("/mesh/lattice/cubes", e.cubes);
        out.write("/mesh/lattice/fraction", e.fraction);
        out.write("/mesh/lattice/centroid", e.centroid);
        out.write_table("/mesh/lattice/corner", e.corner);
        out.write("/mesh/lattice/weight", e.weight);
        file.attribute("/mesh/lattice", "spacing_m", e.spacing_m);
    }
    if (!model.nodule.empty()) {
        out.write("/nodule/points", model.nodule.points);
        out.write_table("/nodule/triangles", model.nodule.triangles);
    }
    out.write("/heuristic_a", model.heuristic_a);
    out.write("/heuristic_b", model.heuristic_b);
    out.write_texts("/cases/names", model.case_names);
    out.write("/cases/contact", model.contact_m);
    out.write("/cases/direction", model.direction);
    out.write("/cases/magnitude", model.magnitude_m);
    if (model.contact_force_N.rows() > 0) out.write("/cases/contact_force", model.contact_force_N);
    if (model.case_radius_m.size() > 0) out.write("/cases/radius", model.case_radius_m);
    if (model.energy_model)
        write_energy_model(file, *model.energy_model);
    else
        write_sets(file, model);
}

int format_of(const TissueModel& model) {
    if (model.energy_model && model.energy_model->patch.curve == ContactCurve::compression) return pulled_format_version;
    if (model.energy_model && !model.energy_model->curve.hookean()) return curve_format_version;
    if (model.energy_model && !model.energy_model->sizes.empty()) return rows_format_version;
    if (!model.mesh.embedding.empty()) return embedded_format_version;
    if (model.energy_model && model.energy_model->contact_log_scale.size() > 0) return adapted_format_version;
    if (model.energy_model && !model.energy_model->relaxation.empty()) return time_format_version;
    return model.energy_model ? energy_model_format_version : format_version;
}

void write_model(const std::string& file, const TissueModel& model, const Provenance& provenance) {
    Hdf5Writer out(file, "model", provenance, format_of(model));
    write_tissue(out, model);
    out.commit();
}

TissueModel read_model(const std::string& file) {
    return read_model(Hdf5Reader(file, "model"));
}

TissueModel read_model(const Hdf5Reader& file) {
    TissueModel model;
    model.study = file.text_attribute("/", "study");
    model.law = file.text_attribute("/", "law");
    model.modulus_N_m = file.number_attribute("/", "modulus_N_m");
    model.mesh.topology = file.text_attribute("/", "topology");
    const std::vector<std::string>& known = topologies().names();
    if (std::find(known.begin(), known.end(), model.mesh.topology) == known.end())
        file.refuse("/", fmt::format("attribute 'topology' is '{}', which is not known; train the study again", model.mesh.topology));
    if (!(model.modulus_N_m > 0) || !std::isfinite(model.modulus_N_m))
        file.refuse("/", fmt::format("attribute 'modulus_N_m' is {}, must be a finite number > 0", model.modulus_N_m));
    const bool solid = file.has("/mesh/tetrahedra");
    const MeshNames& names = names_of(solid);
    TableReader in(file, tissue_table(solid), {{"D", solid ? 3 : 2}});
    SpringMesh& mesh = model.mesh;
    mesh.nodes = in.field("/mesh/nodes");
    mesh.springs = in.table_of<2>("/mesh/springs");
    mesh.simplices = in.field(names.simplices).cast<int>();
    mesh.facets = solid ? Cells(in.field("/mesh/facets").cast<int>()) : loop_facets(in.integers("/mesh/boundary"));
    mesh.fixed = in.integers("/mesh/fixed");
    if (const auto fault = mesh_fault(mesh)) in.refuse("/mesh/" + fault->part, fault->why);
    if (solid) read_embedding(file, in, mesh);
    refuse_twins(in, mesh);
    if (solid) model.nodule = read_nodule(in, mesh);
    mesh.incident_measure = in.vector(names.incident_measure);
    mesh.node_measure = in.vector(names.node_measure);
    model.node_mass_kg = in.vector("/node_mass");
    for (int node = 0; node < mesh.node_count(); ++node)
        for (const auto& [name, value] : {std::pair<const char*, double>{names.node_measure, mesh.node_measure[node]}, {"/node_mass", model.node_mass_kg[node]}})
            if ((value > 0) != (node >= mesh.embedding.node_count()))
                in.refuse(name, fmt::format("of node {} is {:g}; it must be 0 for an embedded solid's own nodes, and above 0 for others", node, value));
    model.heuristic_a = in.vector("/heuristic_a");
    model.heuristic_b = in.vector("/heuristic_b");
    model.case_names = in.texts("/cases/names");
    model.contact_m = in.field("/cases/contact");
    model.direction = in.field("/cases/direction");
    model.magnitude_m = in.vector("/cases/magnitude");
    if (model.case_count() > 0 && model.magnitude_m.maxCoeff() > mesh.size_m())
        in.refuse("/cases/magnitude", fmt::format("goes to {:.3g} mm, beyond the tissue's size of {:.3g} mm", 1e3 * model.magnitude_m.maxCoeff(), 1e3 * mesh.size_m()));
    if (solid && in.has("/cases/radius")) model.case_radius_m = in.vector("/cases/radius");
    if (in.has("/cases/contact_force")) model.contact_force_N = in.field("/cases/contact_force");
    if (file.has("/law"))
        model.energy_model = read_energy_model(file, mesh);
    else
        read_sets(in, model);
    const Eigen::VectorXd radii_m = model.energy_model ? model.energy_model->sizes.radii_m : Eigen::VectorXd();
    if ((model.case_radius_m.size() > 0) != (radii_m.size() > 0)) in.refuse("/cases/radius", "and /law/radii belong together");
    if (radii_m.size() > 0 && !(model.case_radius_m.minCoeff() >= radii_m[0] && model.case_radius_m.maxCoeff() <= radii_m[radii_m.size() - 1]))
        in.refuse("/cases/radius", "is outside the range of /law/radii");
    try {
        make_spring_law(model.law);
    } catch (const MismatchError& e) {
        in.refuse("/", fmt::format("attribute 'law': {}", e.what()));
    }
    for (Eigen::Index c = 0; c < model.contact_m.rows(); ++c) try {
            check_on_surface(mesh, model.contact_m.row(c).transpose());
        } catch (const MismatchError& e) {
            in.refuse("/cases/contact", e.what());
        }
    return model;
}

}  // namespace tissue
