#include "export/vtu.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "mesh/cells.h"
#include "springs/equilibrium.h"
#include "springs/spring_law.h"

namespace tissue {
namespace {

/// VTK's numbers of the cell types in use.
enum CellType { vertex = 1, line = 3, quad = 9, tetrahedron = 10, hexahedron = 12 };

/// Writes the XML of one grid. Numbers are the shortest text that reads back to the same double.
class Grid {
   public:
    explicit Grid(Eigen::Index points) : points_(points) {}

    /// A field (N x D), padded with zeros to three components.
    void at_points(const std::string& name, const NodeField& field) { point_data_ += array(name, "Float64", 3, vectors(field)); }
    void at_points(const std::string& name, const Eigen::VectorXd& values) {
        point_data_ += array(name, "Float64", 1, numbers(values));
    }
    void at_points(const std::string& name, const std::vector<int>& values) {
        point_data_ += array(name, "Int32", 1, numbers(values));
    }
    void at_cells(const std::string& name, const Eigen::VectorXd& values) {
        cell_data_ += array(name, "Float64", 1, numbers(values));
    }
    void of_the_whole(const std::string& name, double value) {
        field_data_ += fmt::format("<DataArray type=\"Float64\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n", name, value);
    }
    void place(const NodeField& positions) { places_ += array("Points", "Float64", 3, vectors(positions)); }
    void cell(CellType type, const std::vector<int>& nodes) {
        connectivity_ += numbers(nodes) + " ";
        end_ += nodes.size();
        offsets_ += fmt::format("{} ", end_);
        types_ += fmt::format("{} ", static_cast<int>(type));
        ++cells_;
    }

    std::string xml() const {
        return fmt::format(
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
            "<UnstructuredGrid>\n<FieldData>\n{}</FieldData>\n"
            "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n"
            "<PointData Vectors=\"displacement_m\">\n{}</PointData>\n<CellData>\n{}</CellData>\n<Points>\n{}</Points>\n"
            "<Cells>\n{}{}{}</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
            field_data_, points_, cells_, point_data_, cell_data_,
            places_, array("connectivity", "Int64", 1, connectivity_), array("offsets", "Int64", 1, offsets_),
            array("types", "UInt8", 1, types_));
    }

   private:
    template <class Values>
    static std::string numbers(const Values& values) {
        std::string text;
        for (const auto value : values) text += fmt::format("{} ", value);
        return text;
    }
    static std::string vectors(const NodeField& field) {
        std::string text;
        for (Eigen::Index i = 0; i < field.rows(); ++i) {
            for (Eigen::Index d = 0; d < 3; ++d) text += fmt::format("{} ", d < field.cols() ? field(i, d) : 0.0);
            text += '\n';
        }
        return text;
    }
    static std::string array(const std::string& name, const char* type, int components, const std::string& values) {
        return fmt::format(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n{}\n</DataArray>\n", type, name,
            components, values);
    }

    Eigen::Index points_;
    std::size_t cells_ = 0, end_ = 0;
    std::string places_, point_data_, cell_data_, field_data_, connectivity_, offsets_, types_;
};

std::string xml_text(const std::string& text) {
    std::string safe;
    for (const char c : text) safe += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
    return safe;
}

/// Node numbers of each cell, if the nodes are a lattice numbered along x, then y, then z; else empty. Nodes are in
/// VTK's order: around the cell; in space around its lower face, then its upper face.
std::vector<std::vector<int>> lattice_cells(const NodeField& nodes) {
    const Eigen::Index N = nodes.rows(), D = nodes.cols();
    std::vector<int> stride{1}, count;  // along each axis: stride to the next node, and number of nodes
    for (Eigen::Index d = 0; d < D; ++d) {
        Eigen::Index end = stride.back();
        const auto in_line = [&](Eigen::Index i) { return (nodes.row(i).tail(D - d - 1) - nodes.row(0).tail(D - d - 1)).isZero(0); };
        while (end < N && in_line(end)) ++end;
        if (end % stride.back() != 0 || N % end != 0 || end / stride.back() < 2) return {};
        count.push_back(static_cast<int>(end / stride.back()));
        stride.push_back(static_cast<int>(end));
    }
    const auto place = [&](Eigen::Index i, Eigen::Index d) { return static_cast<int>(i) / stride[static_cast<std::size_t>(d)] % count[static_cast<std::size_t>(d)]; };
    for (Eigen::Index i = 0; i < N; ++i)
        for (Eigen::Index d = 0; d < D; ++d)
            if (nodes(i, d) != nodes(place(i, d) * stride[static_cast<std::size_t>(d)], d)) return {};
    std::vector<std::vector<int>> cells;
    for (int i = 0; i < N; ++i) {
        bool last = false;
        for (Eigen::Index d = 0; d < D; ++d) last = last || place(i, d) + 1 == count[static_cast<std::size_t>(d)];
        if (last) continue;
        std::vector<int> cell{i, i + 1, i + 1 + stride[1], i + stride[1]};
        for (std::size_t k = 0; D == 3 && k < 4; ++k) cell.push_back(cell[k] + stride[2]);
        cells.push_back(cell);
    }
    return cells;
}

/// In space, the corners of the cells in VTK's order.
std::vector<std::vector<int>> volumes_of(const SpringMesh& mesh) {
    constexpr int around[] = {0, 1, 3, 2, 4, 5, 7, 6};
    std::vector<std::vector<int>> volumes;
    if (!mesh.is_solid()) return volumes;
    const Cells cells = mesh_cells(mesh);
    for (Eigen::Index c = 0; c < cells.rows(); ++c) {
        volumes.emplace_back();
        for (Eigen::Index k = 0; k < cells.cols(); ++k) volumes.back().push_back(cells(c, around[k]));
    }
    return volumes;
}

/// The displaced spring mesh with its nodal forces. volume_Pa: in space, stiffness of the cells.
std::string mesh_vtu(const TissueModel& model, const Eigen::VectorXd& theta, const NodeField& displacement,
                     const NodeField& force, const Eigen::VectorXd& volume_Pa = {}) {
    const SpringMesh& mesh = model.mesh;
    std::vector<int> fixed(static_cast<std::size_t>(mesh.node_count()), 0);
    for (int node : mesh.fixed) fixed[static_cast<std::size_t>(node)] = 1;
    const std::vector<std::vector<int>> volumes = volumes_of(mesh);
    // each array covers springs, then cells, and is 0 where it does not apply: VTK's reader does not accept NaN in text
    const Eigen::Index S = mesh.spring_count(), cells = S + static_cast<Eigen::Index>(volumes.size());
    Eigen::VectorXd stiffness = Eigen::VectorXd::Zero(cells), rest_length = stiffness, volume_stiffness = stiffness;
    stiffness.head(S) = theta;
    // supports are not cells
    if (volume_Pa.size() > 0 && mesh.is_solid()) volume_stiffness.tail(cells - S) = volume_Pa.head(cells - S);

    Grid grid(mesh.node_count());
    for (int s = 0; s < mesh.spring_count(); ++s) {
        grid.cell(line, {mesh.springs(s, 0), mesh.springs(s, 1)});
        rest_length[s] = mesh.rest_length(s);
    }
    grid.place(mesh.nodes + displacement);
    grid.at_points("rest_m", mesh.nodes);
    grid.at_points("displacement_m", displacement);
    grid.at_points("force_N", force);
    grid.at_points("mass_kg", model.node_mass_kg);
    grid.at_points("fixed", fixed);
    for (const std::vector<int>& nodes : volumes) grid.cell(hexahedron, nodes);
    grid.at_cells("stiffness_N_m", stiffness);
    grid.at_cells("rest_length_m", rest_length);
    if (!volumes.empty()) grid.at_cells("stiffness_Pa", volume_stiffness);
    return grid.xml();
}

std::string record_vtu(const Cases& cases, const PathRecord& record) {
    const Eigen::Index N = cases.nodes.rows();
    Grid grid(N);
    grid.place(cases.nodes + record.displacement);
    grid.at_points("rest_m", cases.nodes);
    grid.at_points("displacement_m", record.displacement);
    grid.at_points("force_N", record.force);
    grid.of_the_whole("magnitude_m", record.magnitude_m);
    grid.of_the_whole("energy_J", record.energy_J);
    grid.of_the_whole("smallest_J", record.smallest_J);
    const std::vector<std::vector<int>> lattice = lattice_cells(cases.nodes);
    for (const std::vector<int>& nodes : lattice) grid.cell(nodes.size() == 8 ? hexahedron : quad, nodes);
    const bool solid_shape = cases.shape && cases.shape->is_solid();
    for (Eigen::Index t = 0; solid_shape && t < cases.shape->simplices.rows(); ++t) {
        const auto corners = cases.shape->simplices.row(t);
        grid.cell(tetrahedron, {corners.begin(), corners.end()});
    }
    if (lattice.empty() && !solid_shape)
        for (int i = 0; i < N; ++i) grid.cell(vertex, {i});
    return grid.xml();
}

}  // namespace

Files path_vtu(const Cases& cases, const LoadPath& path) {
    Files files;
    if (path.records.empty()) return files;
    std::string steps;
    for (std::size_t k = 0; k < path.records.size(); ++k) {
        const std::string name = fmt::format("{}/{:04}.vtu", path.name, k);
        files[name] = record_vtu(cases, path.records[k]);
        steps += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", path.records[k].magnitude_m, xml_text(name));
    }
    files[path.name + ".pvd"] =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n" + steps + "</Collection>\n</VTKFile>\n";
    return files;
}

std::string set_vtu(const TissueModel& model, const NamedSet& set, std::string& reason) {
    const SpringMesh& mesh = model.mesh;
    const std::unique_ptr<SpringLaw> law = make_spring_law(model.law);
    NodeField displacement = NodeField::Zero(mesh.node_count(), mesh.dimension());
    if (set.load_case >= 0) {
        const int c = set.load_case;
        const SurfacePoint contact = locate_on_surface(mesh, model.contact_m.row(c).transpose());
        const Eigen::VectorXd push = model.magnitude_m[c] * model.direction.row(c).transpose();
        const Equilibrium state = solve_equilibrium(mesh, *law, set.theta, contact, push);
        reason = reason_of(state.status);
        if (state) displacement = state.displacement;
    } else {
        reason = "it has no load case";
    }
    NodeField force(mesh.node_count(), mesh.dimension());
    Eigen::Map<Eigen::VectorXd>(force.data(), force.size()) = law->force_matrix(mesh, displacement) * set.theta;
    return mesh_vtu(model, set.theta, displacement, force);
}

std::string pressed_vtu(const TissueModel& model, const IndentationOfCase& pressed) {
    const NodeField rest = NodeField::Zero(model.mesh.node_count(), model.mesh.dimension());
    const Eigen::VectorXd& constants = model.energy_model->constants;
    const Eigen::Index S = model.mesh.spring_count();
    return mesh_vtu(model, constants.head(S), pressed.state ? pressed.state.displacement : rest,
                    pressed.state ? pressed.force_N : rest, constants.tail(constants.size() - S));
}

}  // namespace tissue
