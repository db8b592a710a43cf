#include "cases/load_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "error.h"
#include "io/csv_lines.h"

namespace tissue {
namespace {

constexpr int csv_version = 1;

/// FreeFEM's rows: the first field is the kind of row.
class PathLines : public CsvLines {
   public:
    using CsvLines::CsvLines;

    const std::string& kind() const {
        static const std::string none;
        return size() == 0 ? none : field(0);
    }

    void want(std::size_t count) const {
        if (size() != count) refuse(fmt::format("has {} fields, a '{}' row has {}", size(), kind(), count));
    }

    void want_at_least(std::size_t count) const {
        if (size() < count) refuse("has too few fields");
    }

    /// A last field that may hold commas of its own.
    std::string text_from(std::size_t i) const {
        std::size_t start = 0;
        for (; i > 0; --i) start = text().find(',', start) + 1;
        return text().substr(start);
    }
};

PathRecord read_step(const PathLines& line, Eigen::Index node_count) {
    line.want(11);
    PathRecord r;
    r.magnitude_m = line.number(2);
    r.energy_J = line.number(3);
    r.contact_force_N = {line.number(4), line.number(5)};
    r.support_force_N = {line.number(6), line.number(7)};
    r.smallest_J = line.number(8);
    r.newton_iterations = static_cast<int>(line.number(9));
    r.newton_residual = line.number(10);
    r.displacement = NodeField::Constant(node_count, 2, std::nan(""));
    r.force = r.displacement;
    return r;
}

void read_node(const PathLines& line, const SpringMesh& mesh, PathRecord& r) {
    line.want(7);
    int node = 0;
    try {
        node = node_at(mesh, {line.number(1), line.number(2)});
    } catch (const MismatchError& e) {
        line.refuse(e.what());
    }
    if (!std::isnan(r.displacement(node, 0))) line.refuse("the node stands twice in its record");
    // whole rows: Eigen's comma initializer aborts when a refusal leaves it half done
    r.displacement.row(node) = Eigen::RowVector2d(line.number(3), line.number(4));
    r.force.row(node) = Eigen::RowVector2d(line.number(5), line.number(6));
}

}  // namespace

LoadPath read_path_csv(const std::string& file, const NodeField& nodes) {
    PathLines line(file);
    if (!line.next() || line.kind() != "tissuectl load path") line.refuse("is not a load path of this project");
    line.want(2);
    if (line.number(1) != csv_version) line.refuse("is of another format version; this program reads 1");

    SpringMesh lattice;
    lattice.nodes = nodes;
    LoadPath path;
    Eigen::Index rows = 0;
    bool ended = false;
    const auto close_record = [&] {
        if (!path.records.empty() && rows != nodes.rows())
            line.refuse(fmt::format("a record ends after {} of {} nodes", rows, nodes.rows()));
        rows = 0;
    };
    while (line.next()) {
        if (ended) line.refuse("stands after the end row");
        if (line.kind() == "step") {
            close_record();
            path.records.push_back(read_step(line, nodes.rows()));
            const auto& r = path.records;
            if (r.size() > 1 && !(r.back().magnitude_m > r[r.size() - 2].magnitude_m))
                line.refuse("the magnitudes do not ascend");
        } else if (line.kind() == "node" && !path.records.empty()) {
            read_node(line, lattice, path.records.back());
            ++rows;
        } else if (line.kind() == "end") {
            line.want(2);
            close_record();
            if (line.number(1) != static_cast<double>(path.records.size())) line.refuse("records are missing");
            ended = true;
        } else if (line.kind() == "lost") {
            line.want_at_least(3);
            close_record();
            if (line.number(1) != static_cast<double>(path.records.size())) line.refuse("records are missing");
            path.lost = line.text_from(2);
            ended = true;
        } else {
            line.refuse("is neither a step, a node, an end nor a lost row");
        }
    }
    if (!ended) line.refuse("the file is truncated: it has no end row");
    return path;
}

LoadPath mirrored(const LoadPath& path, const NodeField& nodes, double width_m) {
    SpringMesh lattice;
    lattice.nodes = nodes;
    std::vector<int> image;
    for (Eigen::Index i = 0; i < nodes.rows(); ++i)
        image.push_back(node_at(lattice, {width_m - nodes(i, 0), nodes(i, 1)}));
    const auto reflect = [](Eigen::Vector2d v) { return Eigen::Vector2d(-v.x(), v.y()); };
    LoadPath result = path;
    result.name += "-mirror";
    result.contact_m.x() = width_m - path.contact_m.x();
    result.direction = reflect(path.direction);
    for (std::size_t r = 0; r < path.records.size(); ++r) {
        PathRecord& record = result.records[r];
        record.contact_force_N = reflect(record.contact_force_N);
        record.support_force_N = reflect(record.support_force_N);
        for (std::size_t i = 0; i < image.size(); ++i) {
            const auto from = static_cast<Eigen::Index>(i), to = static_cast<Eigen::Index>(image[i]);
            record.displacement.row(to) = reflect(path.records[r].displacement.row(from));
            record.force.row(to) = reflect(path.records[r].force.row(from));
        }
    }
    return result;
}

namespace {

void write_measurement(Hdf5Writer& out, const Measurement& m) {
    out.write_texts("/measurement/origin", {m.origin}, "comments at the head of the measured data");
    out.write_texts("/measurement/outliers", m.outliers, "rows far from their repeats; they are kept");
    out.write("/measurement/force_noise", Eigen::VectorXd(Eigen::VectorXd::Constant(1, m.force_noise)), "1",
              "standard deviation of a component of the force, relative to the force");
    out.write("/measurement/displacement_noise", Eigen::VectorXd(Eigen::VectorXd::Constant(1, m.displacement_noise_m)),
              "m", "standard deviation of a component of the displacement");
    out.write_integers("/measurement/counts", {3}, {m.rows, m.contacts, m.repeats},
                       "rows, contacts, degrees of freedom of the noise");
    out.attribute("/measurement", "noise_source", m.noise_source);
}

Measurement read_measurement(const Hdf5Reader& in) {
    const std::vector<std::string> origin = in.texts("/measurement/origin");
    const Eigen::VectorXd force = in.vector("/measurement/force_noise"),
                          displacement = in.vector("/measurement/displacement_noise");
    const std::vector<int> counts = in.integers("/measurement/counts");
    if (origin.size() != 1 || force.size() != 1 || displacement.size() != 1 || counts.size() != 3)
        in.refuse("/measurement", "its datasets do not have the expected sizes");
    return {origin[0], counts[0], counts[1], counts[2], force[0], displacement[0],
            in.text_attribute("/measurement", "noise_source"), in.texts("/measurement/outliers")};
}

/// Paths of measured data: contact, direction and role are read already.
void write_measured_path(Hdf5Writer& out, const std::string& group, const LoadPath& path) {
    const auto R = static_cast<Eigen::Index>(path.records.size());
    Eigen::VectorXd magnitude(R);
    NodeField force(R, 2), aside(R, 2), again(path.again_N ? 1 : 0, 2);
    for (Eigen::Index r = 0; r < R; ++r) {
        const PathRecord& record = path.records[static_cast<std::size_t>(r)];
        magnitude[r] = record.magnitude_m;
        force.row(r) = record.contact_force_N;
        aside.row(r) = record.aside_m;
    }
    if (path.again_N) again.row(0) = *path.again_N;
    out.write(group + "magnitude", magnitude, "m", "how far the contact is pushed (R)");
    out.write(group + "aside", aside, "m", "what the push strayed from the direction (R x D)");
    out.write(group + "contact_force", force, "N", "force of the indenter on the tissue (R x D)");
    out.write(group + "again", again, "N", "contact force on average when the push was measured again (0 or 1 x D)");
}

void read_measured_path(const Hdf5Reader& in, const std::string& group, LoadPath& path) {
    const Eigen::VectorXd magnitude = in.vector(group + "magnitude");
    const NodeField force = in.field(group + "contact_force"), aside = in.field(group + "aside"),
                    again = in.field(group + "again");
    if (force.rows() != magnitude.size() || aside.rows() != magnitude.size() || force.cols() != 2 || aside.cols() != 2)
        in.refuse(group, "its datasets do not have the same number of records");
    for (Eigen::Index r = 0; r < magnitude.size(); ++r)
        path.records.push_back(measured_record(magnitude[r], force.row(r), aside.row(r)));
    if (again.rows() == 1) path.again_N = again.row(0);
}

}  // namespace

const PathRecord* LoadPath::record_at(double magnitude_m) const {
    for (const PathRecord& r : records)
        if (std::abs(r.magnitude_m - magnitude_m) <= 1e-9 * magnitude_m) return &r;
    return nullptr;
}

PathRecord measured_record(double magnitude_m, const Eigen::Vector2d& force_N, const Eigen::Vector2d& aside_m) {
    return {magnitude_m, {}, {}, force_N, Eigen::Vector2d::Zero(), 0, 0, 0, 0, aside_m};
}

namespace {

/// "10mm" a magnitude: as many digits as tell all of them apart, at least so many.
std::vector<std::string> labels_of(const std::vector<double>& magnitudes_m, int least_digits) {
    for (int digits = least_digits; digits <= 17; ++digits) {
        std::vector<std::string> labels;
        for (double m : magnitudes_m) labels.push_back(fmt::format("{:.{}g}mm", 1e3 * m, digits));
        if (std::set<std::string>(labels.begin(), labels.end()).size() == labels.size()) return labels;
    }
    throw MismatchError("two load cases of one path have the same magnitude");
}

}  // namespace

std::vector<LoadCase> load_cases(const Cases& cases) {
    std::vector<LoadCase> list;
    const std::vector<std::string> labels = labels_of(cases.magnitudes_m, 6);
    for (const LoadPath& path : cases.paths) {
        if (path.role != "train") continue;
        if (cases.measurement) {
            std::vector<double> measured_m;
            for (const PathRecord& r : path.records) measured_m.push_back(r.magnitude_m);
            const std::vector<std::string> own = labels_of(measured_m, 5);
            for (std::size_t r = 0; r < own.size(); ++r) list.push_back({path.name + "-" + own[r], &path, &path.records[r]});
        }
        for (std::size_t m = 0; m < labels.size(); ++m) {
            const double magnitude = cases.magnitudes_m[m];
            const PathRecord* found = path.record_at(magnitude);
            if (!found && !path.lost.empty()) continue;
            if (!found)
                throw MismatchError(fmt::format("load path '{}' has no record at {} mm", path.name, 1e3 * magnitude));
            list.push_back({path.name + "-" + labels[m], &path, found});
        }
    }
    return list;
}

namespace {

void write_shape(Hdf5Writer& out, const Shape& shape) {
    std::vector<int> corners, edges;
    for (Eigen::Index t = 0; t < shape.triangles.rows(); ++t)
        for (int i = 0; i < 3; ++i) corners.push_back(shape.triangles(t, i));
    for (const auto& edge : shape.fixed_edges) edges.insert(edges.end(), edge.begin(), edge.end());
    out.write_integers("/shape/triangles", {shape.region.size(), 3}, corners, "triangles between the nodes (T x 3)");
    out.write_integers("/shape/region", {shape.region.size()}, shape.region, "0: base material, else 1 + named region (T)");
    out.write_integers("/shape/fixed_edges", {shape.fixed_edges.size(), 2}, edges, "held edges of the outline (B x 2)");
}

Shape read_shape_of(const Hdf5Reader& in, const NodeField& nodes) {
    Shape shape;
    shape.nodes = nodes;
    const NodeField triangles = in.field("/shape/triangles"), edges = in.field("/shape/fixed_edges");
    shape.region = in.integers("/shape/region");
    const auto are_nodes = [&](const NodeField& m, Eigen::Index columns) {
        return m.rows() > 0 && m.cols() == columns && m.minCoeff() >= 0 && m.maxCoeff() < static_cast<double>(nodes.rows());
    };
    if (!are_nodes(triangles, 3) || !are_nodes(edges, 2) ||
        shape.region.size() != static_cast<std::size_t>(triangles.rows()))
        in.refuse("/shape", "its datasets do not fit the nodes and each other");
    shape.triangles = triangles.cast<int>();
    for (Eigen::Index e = 0; e < edges.rows(); ++e)
        shape.fixed_edges.push_back({static_cast<int>(edges(e, 0)), static_cast<int>(edges(e, 1))});
    return shape;
}

}  // namespace

void write_cases(const std::string& file, const Cases& cases, const Provenance& provenance) {
    Hdf5Writer out(file, "cases", provenance);
    out.attribute("/", "study", cases.study);
    out.write("/nodes", cases.nodes, "m", "lattice nodes at rest (N x D)");
    if (cases.shape) write_shape(out, *cases.shape);
    out.write("/magnitudes", Array{{cases.magnitudes_m.size()}, cases.magnitudes_m}, "m",
              "push lengths that are load cases");
    std::vector<std::string> names;
    for (const LoadPath& path : cases.paths) names.push_back(path.name);
    out.write_texts("/path_names", names, "load paths in the study's order");
    if (cases.measurement) write_measurement(out, *cases.measurement);
    for (const LoadPath& path : cases.paths) {
        const std::string group = "/paths/" + path.name + "/";
        out.write_texts(group + "role", {path.role, path.lost}, "what the path is for, and why FE lost it, if so");
        out.write(group + "depth", Eigen::VectorXd(Eigen::VectorXd::Constant(1, path.depth_m)), "m",
                  "how deep it was to go");
        out.write(group + "contact", Eigen::VectorXd(path.contact_m), "m", "contact at rest (D)");
        out.write(group + "direction", Eigen::VectorXd(path.direction), "1", "unit vector of the push (D)");
        if (cases.measurement) {
            write_measured_path(out, group, path);
            continue;
        }
        const std::size_t R = path.records.size(), N = static_cast<std::size_t>(cases.nodes.rows()),
                          D = static_cast<std::size_t>(cases.nodes.cols());
        Array magnitude{{R}, {}}, energy{{R}, {}}, J{{R}, {}}, residual{{R}, {}}, contact{{R, D}, {}},
            support{{R, D}, {}}, u{{R, N, D}, {}}, f{{R, N, D}, {}};
        std::vector<int> newton;
        for (const PathRecord& r : path.records) {
            magnitude.values.push_back(r.magnitude_m);
            energy.values.push_back(r.energy_J);
            J.values.push_back(r.smallest_J);
            residual.values.push_back(r.newton_residual);
            newton.push_back(r.newton_iterations);
            contact.values.insert(contact.values.end(), r.contact_force_N.begin(), r.contact_force_N.end());
            support.values.insert(support.values.end(), r.support_force_N.begin(), r.support_force_N.end());
            u.values.insert(u.values.end(), r.displacement.data(), r.displacement.data() + r.displacement.size());
            f.values.insert(f.values.end(), r.force.data(), r.force.data() + r.force.size());
        }
        out.write(group + "magnitude", magnitude, "m", "how far the contact is pushed (R)");
        out.write(group + "displacement", u, "m", "u at the lattice nodes (R x N x D)");
        out.write(group + "force", f, "N", "external nodal force that holds u, lumped to the lattice (R x N x D)");
        out.write(group + "contact_force", contact, "N", "force of the indenter on the tissue (R x D)");
        out.write(group + "support_force", support, "N", "force of the supports on the tissue (R x D)");
        out.write(group + "energy", energy, "J", "elastic energy (R)");
        out.write(group + "smallest_J", J, "1", "smallest det F in the tissue (R)");
        out.write(group + "newton_residual", residual, "1", "largest free force over largest reaction (R)");
        out.write_integers(group + "newton_iterations", {R}, newton, "Newton iterations since the record before (R)");
    }
    out.commit();
}

Cases read_cases(const std::string& file) {
    const Hdf5Reader in(file, "cases");
    Cases cases;
    cases.study = in.text_attribute("/", "study");
    cases.nodes = in.field("/nodes");
    const std::vector<std::string> groups = in.children("/");
    if (std::find(groups.begin(), groups.end(), "shape") != groups.end()) cases.shape = read_shape_of(in, cases.nodes);
    const Eigen::VectorXd magnitudes = in.vector("/magnitudes");
    cases.magnitudes_m.assign(magnitudes.begin(), magnitudes.end());
    const Eigen::Index N = cases.nodes.rows(), D = cases.nodes.cols();
    const std::vector<std::string> parts = in.children("/");
    if (std::find(parts.begin(), parts.end(), "measurement") != parts.end()) cases.measurement = read_measurement(in);
    std::set<std::string> names;
    for (const std::string& name : in.texts("/path_names")) {
        if (!names.insert(name).second) in.refuse("/path_names", "'" + name + "' stands twice");
        const std::string group = "/paths/" + name + "/";
        const std::vector<std::string> role = in.texts(group + "role");
        const Eigen::VectorXd depth = in.vector(group + "depth"), where = in.vector(group + "contact"),
                              direction = in.vector(group + "direction");
        if (role.size() != 2 || depth.size() != 1) in.refuse(group, "has no role or no depth");
        if (D != 2 || where.size() != D || direction.size() != D) in.refuse(group, "is not of two dimensions");
        LoadPath path;
        path.name = name;
        path.role = role[0];
        path.lost = role[1];
        path.depth_m = depth[0];
        path.contact_m = where;
        path.direction = direction;
        if (cases.measurement) {
            read_measured_path(in, group, path);
            cases.paths.push_back(std::move(path));
            continue;
        }
        const Eigen::VectorXd magnitude = in.vector(group + "magnitude"), energy = in.vector(group + "energy"),
                              J = in.vector(group + "smallest_J"), residual = in.vector(group + "newton_residual");
        const NodeField contact = in.field(group + "contact_force"), support = in.field(group + "support_force");
        const Array u = in.array(group + "displacement"), f = in.array(group + "force");
        const std::vector<int> newton = in.integers(group + "newton_iterations");
        const auto R = static_cast<std::size_t>(magnitude.size());
        const std::vector<std::size_t> shape = {R, static_cast<std::size_t>(N), static_cast<std::size_t>(D)};
        const auto same_length = [&](auto size) { return static_cast<std::size_t>(size) == R; };
        if (u.shape != shape || f.shape != shape || !same_length(energy.size()) || !same_length(J.size()) ||
            !same_length(residual.size()) || !same_length(newton.size()) || !same_length(contact.rows()) ||
            !same_length(support.rows()) || contact.cols() != D || support.cols() != D)
            in.refuse(group, "its datasets do not have the same number of records and nodes");
        for (std::size_t r = 0; r < R; ++r) {
            const auto i = static_cast<Eigen::Index>(r);
            const auto at = [&](const Array& a) {
                return Eigen::Map<const NodeField>(a.values.data() + i * N * D, N, D);
            };
            path.records.push_back({magnitude[i], at(u), at(f), contact.row(i), support.row(i), energy[i], J[i],
                                    newton[r], residual[i]});
        }
        cases.paths.push_back(std::move(path));
    }
    return cases;
}

}  // namespace tissue
