#include "cases/load_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "cases/path_lines.h"
#include "error.h"

namespace tissue {
namespace {

constexpr int csv_version = 1, two_tools_version = 2;
constexpr double same_magnitude = 1e-9;  // relative

/// nodes: of the lattice (N x D). second: whether the row ends with the force of a second disc.
PathRecord read_step(const PathLines& line, const NodeField& nodes, bool second) {
    const auto D = static_cast<std::size_t>(nodes.cols());
    line.want(7 + (second ? 3 : 2) * D);
    PathRecord r;
    r.magnitude_m = line.number(2);
    r.energy_J = line.number(3);
    r.contact_force_N = line.point(4, D);
    r.support_force_N = line.point(4 + D, D);
    r.smallest_J = line.number(4 + 2 * D);
    const double iterations = line.number(5 + 2 * D);
    if (iterations < 0 || iterations > std::numeric_limits<int>::max() || iterations != std::floor(iterations))
        line.refuse(fmt::format("{:g} is not a number of Newton iterations", iterations));
    r.newton_iterations = static_cast<int>(iterations);
    r.newton_residual = line.number(6 + 2 * D);
    if (second) r.second_force_N = line.point(7 + 2 * D, D);
    r.displacement = NodeField::Constant(nodes.rows(), nodes.cols(), std::nan(""));
    r.force = r.displacement;
    return r;
}

void read_node(const PathLines& line, const SpringMesh& mesh, PathRecord& r) {
    const auto D = static_cast<std::size_t>(mesh.dimension());
    line.want(1 + 3 * D);
    int node = 0;
    try {
        node = node_at(mesh, line.point(1, D));
    } catch (const MismatchError& e) {
        line.refuse(e.what());
    }
    if (!std::isnan(r.displacement(node, 0))) line.refuse("the node is twice in its record");
    r.displacement.row(node) = line.point(1 + D, D).transpose();
    r.force.row(node) = line.point(1 + 2 * D, D).transpose();
}

}  // namespace

LoadPath read_path_csv(const std::string& file, const NodeField& nodes, bool second) {
    PathLines line(file);
    if (!line.next() || line.kind() != "tissuectl load path") line.refuse("is not a tissuectl load path");
    line.want(2);
    if (line.number(1) != csv_version && line.number(1) != two_tools_version) line.refuse("has another format version; this program reads 1 and 2");
    if (second != (line.number(1) == two_tools_version)) line.refuse(second ? "has one disc, and the path has two" : "has two discs, and the path has one");

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
        if (ended) line.refuse("follows the end row");
        if (line.kind() == "step") {
            close_record();
            path.records.push_back(read_step(line, nodes, second));
            const auto& r = path.records;
            if (r.size() > 1 && !(r.back().magnitude_m > r[r.size() - 2].magnitude_m))
                line.refuse("the magnitudes must ascend");
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
            line.refuse("is not a step, node, end or lost row");
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
        image.push_back(node_at(lattice, Eigen::Vector2d(width_m - nodes(i, 0), nodes(i, 1))));
    const auto reflect = [](const Eigen::Vector2d& v) { return Eigen::Vector2d(-v.x(), v.y()); };
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

Cases without_mirrors(const Cases& cases) {
    std::set<std::string> images;
    for (const LoadPath& path : cases.paths) images.insert(path.name + "-mirror");
    Cases result = cases;
    const auto is_image = [&](const LoadPath& path) { return path.role == "train" && images.count(path.name) > 0; };
    result.paths.erase(std::remove_if(result.paths.begin(), result.paths.end(), is_image), result.paths.end());
    return result;
}

const PathRecord* LoadPath::record_at(double magnitude_m) const {
    for (const PathRecord& r : records)
        if (std::abs(r.magnitude_m - magnitude_m) <= same_magnitude * magnitude_m) return &r;
    return nullptr;
}

PathRecord measured_record(double magnitude_m, const Point& force_N, const Point& aside_m) {
    return {magnitude_m, {}, {}, force_N, Point(Point::Zero(force_N.size())), 0, 0, 0, 0, aside_m};
}

namespace {

/// Labels such as "10mm", with at least least_digits significant digits and as many as make all labels different.
std::vector<std::string> labels_of(const std::vector<double>& magnitudes_m, int least_digits) {
    for (int digits = least_digits; digits <= 17; ++digits) {
        std::vector<std::string> labels;
        for (double m : magnitudes_m) labels.push_back(fmt::format("{:.{}g}mm", 1e3 * m, digits));
        if (std::set<std::string>(labels.begin(), labels.end()).size() == labels.size()) return labels;
    }
    throw MismatchError("two load cases of one path have the same magnitude");
}

}  // namespace

std::vector<double> load_magnitudes(const Cases& cases, const LoadPath& path) {
    std::vector<double> magnitudes;
    if (cases.measurement) {
        for (const PathRecord& r : path.records) magnitudes.push_back(r.magnitude_m);
        return magnitudes;
    }
    if (path.direction.size() != 3) return cases.magnitudes_m;
    const double times = path.radius_m > 0 && cases.disc_radius_m > 0 ? path.radius_m / cases.disc_radius_m : 1;
    for (double of_own : cases.magnitudes_m) {
        const double m = times * of_own;
        if (m > path.depth_m * (1 + same_magnitude)) {
            if (magnitudes.empty() || magnitudes.back() < path.depth_m * (1 - same_magnitude)) magnitudes.push_back(path.depth_m);
            break;
        }
        magnitudes.push_back(m);
    }
    return magnitudes;
}

std::vector<LoadCase> load_cases(const Cases& cases) {
    std::vector<LoadCase> list;
    labels_of(cases.magnitudes_m, 6);  // refuses two equal magnitudes
    for (const LoadPath& path : cases.paths) {
        if (path.role != "train") continue;
        const std::vector<double> magnitudes = load_magnitudes(cases, path);
        const std::vector<std::string> labels = labels_of(magnitudes, cases.measurement ? 5 : 6);
        for (std::size_t m = 0; m < labels.size(); ++m) {
            const PathRecord* found = cases.measurement ? &path.records[m] : path.record_at(magnitudes[m]);
            if (!found && !path.lost.empty()) continue;
            if (!found)
                throw MismatchError(fmt::format("load path '{}' has no record at {} mm", path.name, 1e3 * magnitudes[m]));
            list.push_back({path.name + "-" + labels[m], &path, found});
        }
    }
    return list;
}

}  // namespace tissue
