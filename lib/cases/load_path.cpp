#include "cases/load_path.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <sstream>

#include "error.h"
#include "io/atomic_file.h"

namespace tissue {
namespace {

constexpr int csv_version = 1;

/// The comma-separated fields of one CSV, line by line, with refusals that name the place.
class CsvLines {
   public:
    explicit CsvLines(const std::string& file) : file_(file), in_(read_file(file)) {}

    bool next() {
        std::string line;
        if (!std::getline(in_, line)) return false;
        ++number_;
        fields_.clear();
        std::istringstream split(line);
        for (std::string field; std::getline(split, field, ',');) fields_.push_back(field);
        return true;
    }

    const std::string& kind() const {
        static const std::string none;
        return fields_.empty() ? none : fields_[0];
    }

    void want(std::size_t count) const {
        if (fields_.size() != count)
            refuse(fmt::format("has {} fields, a '{}' row has {}", fields_.size(), kind(), count));
    }

    double number(std::size_t i) const {
        const std::string& field = fields_[i];
        double value = 0;
        const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
        if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value))
            refuse(fmt::format("field {} is '{}', not a finite number", i + 1, field));
        return value;
    }

    void want_at_least(std::size_t count) const {
        if (fields_.size() < count) refuse("has too few fields");
    }

    /// A last field that may hold commas of its own.
    std::string text_from(std::size_t i) const {
        return fmt::format("{}", fmt::join(fields_.begin() + static_cast<std::ptrdiff_t>(i), fields_.end(), ","));
    }

    [[noreturn]] void refuse(const std::string& why) const {
        throw FileError(fmt::format("{}:{}: {}", file_, number_, why));
    }

   private:
    std::string file_;
    std::istringstream in_;
    std::vector<std::string> fields_;
    int number_ = 0;
};

PathRecord read_step(const CsvLines& line, Eigen::Index node_count) {
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

void read_node(const CsvLines& line, const SpringMesh& mesh, PathRecord& r) {
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
    CsvLines line(file);
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

std::vector<LoadCase> load_cases(const Cases& cases) {
    std::vector<LoadCase> list;
    for (const LoadPath& path : cases.paths) {
        if (path.role != "train") continue;
        for (double magnitude : cases.magnitudes_m) {
            const PathRecord* found = nullptr;
            for (const PathRecord& r : path.records)
                if (std::abs(r.magnitude_m - magnitude) < 1e-9 * magnitude) found = &r;
            if (!found && !path.lost.empty()) continue;
            if (!found)
                throw MismatchError(fmt::format("load path '{}' has no record at {} mm", path.name, 1e3 * magnitude));
            list.push_back({fmt::format("{}-{:g}mm", path.name, 1e3 * magnitude), &path, found});
        }
    }
    return list;
}

void write_cases(const std::string& file, const Cases& cases, const Provenance& provenance) {
    Hdf5Writer out(file, "cases", provenance);
    out.attribute("/", "study", cases.study);
    out.write("/nodes", cases.nodes, "m", "lattice nodes at rest (N x D)");
    out.write("/magnitudes", Array{{cases.magnitudes_m.size()}, cases.magnitudes_m}, "m",
              "push lengths that are load cases");
    std::vector<std::string> names;
    for (const LoadPath& path : cases.paths) names.push_back(path.name);
    out.write_texts("/path_names", names, "load paths in the study's order");
    for (const LoadPath& path : cases.paths) {
        const std::string group = "/paths/" + path.name + "/";
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
        out.write_texts(group + "role", {path.role, path.lost}, "what the path is for, and why FE lost it, if so");
        out.write(group + "depth", Eigen::VectorXd(Eigen::VectorXd::Constant(1, path.depth_m)), "m",
                  "how deep it was to go");
        out.write(group + "contact", Eigen::VectorXd(path.contact_m), "m", "contact at rest (D)");
        out.write(group + "direction", Eigen::VectorXd(path.direction), "1", "unit vector of the push (D)");
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
    const Eigen::VectorXd magnitudes = in.vector("/magnitudes");
    cases.magnitudes_m.assign(magnitudes.begin(), magnitudes.end());
    const Eigen::Index N = cases.nodes.rows(), D = cases.nodes.cols();
    for (const std::string& name : in.texts("/path_names")) {
        const std::string group = "/paths/" + name + "/";
        const Eigen::VectorXd magnitude = in.vector(group + "magnitude"), energy = in.vector(group + "energy"),
                              J = in.vector(group + "smallest_J"), residual = in.vector(group + "newton_residual");
        const NodeField contact = in.field(group + "contact_force"), support = in.field(group + "support_force");
        const Array u = in.array(group + "displacement"), f = in.array(group + "force");
        const std::vector<int> newton = in.integers(group + "newton_iterations");
        const Eigen::VectorXd where = in.vector(group + "contact"), direction = in.vector(group + "direction");
        const auto R = static_cast<std::size_t>(magnitude.size());
        const std::vector<std::size_t> shape = {R, static_cast<std::size_t>(N), static_cast<std::size_t>(D)};
        const auto same_length = [&](auto size) { return static_cast<std::size_t>(size) == R; };
        if (D != 2 || u.shape != shape || f.shape != shape || !same_length(energy.size()) || !same_length(J.size()) ||
            !same_length(residual.size()) || !same_length(newton.size()) || !same_length(contact.rows()) ||
            !same_length(support.rows()) || contact.cols() != D || support.cols() != D || where.size() != D ||
            direction.size() != D)
            in.refuse(group, "its datasets do not have the same number of records and nodes");
        LoadPath path;
        path.name = name;
        const std::vector<std::string> role = in.texts(group + "role");
        const Eigen::VectorXd depth = in.vector(group + "depth");
        if (role.size() != 2 || depth.size() != 1) in.refuse(group, "has no role or no depth");
        path.role = role[0];
        path.lost = role[1];
        path.depth_m = depth[0];
        path.contact_m = where;
        path.direction = direction;
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
