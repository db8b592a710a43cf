#include "cases/shape_checks.h"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "error.h"
#include "io/one_line.h"
#include "mesh/facet.h"
#include "springs/energy_model_terms.h"

namespace tissue {
namespace {

[[noreturn]] void refuse(const Study& study, const std::string& key, const std::string& why) {
    throw StudyError(one_line(fmt::format("{}: key '{}': {}", study.file, key, why)));
}

/// Signed distance along a direction from a point to a facet (a segment in the plane, a triangle in space); infinite
/// where the line misses it.
double along_to_facet(const SpringMesh& mesh, Eigen::Index f, const Point& from, const Point& direction) {
    constexpr double none = std::numeric_limits<double>::infinity(), edge = 1e-9;
    const Eigen::Index dimension = mesh.nodes.cols();
    // from + t direction = a + sum_k w_k (corner_k - a), 0 <= w_k, sum w_k <= 1
    Eigen::MatrixXd columns(dimension, dimension);
    columns.col(0) = -direction;
    const Eigen::VectorXd a = mesh.nodes.row(mesh.facets(f, 0)).transpose();
    for (Eigen::Index k = 1; k < dimension; ++k) columns.col(k) = mesh.nodes.row(mesh.facets(f, k)).transpose() - a;
    const double measure = columns.rightCols(dimension - 1).colwise().norm().prod();
    if (std::abs(columns.determinant()) <= 1e-12 * measure) return none;  // the direction is parallel to the facet
    const Eigen::VectorXd solution = columns.inverse() * (from - a);
    const Eigen::VectorXd weight = solution.tail(dimension - 1);
    return weight.minCoeff() >= -edge && weight.sum() <= 1 + edge ? solution[0] : none;
}

/// Inward normal of the facet that the contact lies on; where facets meet, that of the one whose normal is nearest to
/// the path's direction.
Point inward_at(const SpringMesh& mesh, const StudyPath& push) {
    constexpr double same_m = 1e-6;
    double nearest_m = std::numeric_limits<double>::infinity(), squarely = -1;
    Point inward = push.direction;
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        const double away_m = nearest_on_facet(mesh.nodes, mesh.facets, f, push.contact_m).distance_m;
        const Point normal = -facet_normal(mesh.nodes, mesh.facets, f);
        const double into = normal.dot(push.direction);
        if (away_m > nearest_m + same_m || (away_m > nearest_m - same_m && into <= squarely)) continue;
        nearest_m = std::min(nearest_m, away_m);
        squarely = into;
        inward = normal;
    }
    return inward;
}

}  // namespace

namespace {

constexpr double most_along = 1000;  ///< largest ratio of a tissue's length to that of springs, elements or the tool

/// Length of the tool: its half width or its depth, whichever is larger.
double tool_size_m(const Study& study) { return std::max(study.indenter.half_width_m, study.loads.magnitudes_m.empty() ? 0 : study.loads.magnitudes_m.back()); }

}  // namespace

void refuse_wrong_unit(const Study& study) {
    const Study::Geometry& g = study.geometry;
    const double longest_m = std::max({g.width_m, g.length_m, g.height_m}), tool_m = tool_size_m(study);
    if (tool_m > 0 && longest_m > most_along * tool_m)
        refuse(study, longest_m == g.width_m ? "geometry.width_m" : longest_m == g.height_m ? "geometry.height_m" : "geometry.length_m",
               fmt::format("{:g} m is more than {:g} times {:g} m, the tool's half width or displacement. Is this in millimetres? Lengths must be in metres", longest_m, most_along, tool_m));
}

void refuse_wrong_unit(const Study& study, const MshFile& mesh) {
    constexpr double most_in_all = 100'000, farthest = 1000;
    const Study::Geometry& g = study.geometry;
    const double none = std::numeric_limits<double>::infinity();
    Eigen::Array3d low = Eigen::Array3d::Constant(none), high = -low;
    const auto corners = [&](const int* place, int count) {
        for (int i = 0; i < count; ++i) {
            const MshFile::Point& p = mesh.points[static_cast<std::size_t>(place[i])];
            low = low.min(Eigen::Array3d(p.x, p.y, p.z));
            high = high.max(Eigen::Array3d(p.x, p.y, p.z));
        }
    };
    // only corners of elements: gmsh also saves the centres of circles, which may be far away
    for (const MshFile::Element& e : mesh.lines) corners(e.node, 2);
    for (const MshFile::Element& e : mesh.triangles) corners(e.node, 3);
    for (const MshFile::Tetrahedron& e : mesh.tetrahedra) corners(e.node, 4);
    if (!(low <= high).all()) return;  // no elements
    const Eigen::Array3d sides_m = (high - low) * g.unit_m, middle = (high + low) / 2, middle_m = middle * g.unit_m;
    const double longest_m = sides_m.maxCoeff(), away_m = middle_m.matrix().norm();
    const bool springs = study.spring_size_m > 0;
    const bool elements = !springs && study.sizes_m[1] > 0;
    const double tool_m = tool_size_m(study);
    // length of the springs or elements that the shape is divided into; for a mesh in the plane, of the tool
    const double size_m = springs ? study.spring_size_m : elements ? study.sizes_m[1] : tool_m;
    const std::string length = fmt::format("{} is {:.3g} {} long with geometry.unit_m = {:g}", g.shape, longest_m < 1 ? 1e3 * longest_m : longest_m, longest_m < 1 ? "mm" : "m", g.unit_m);
    const std::string what = fmt::format("{} = {:g} m", springs ? "lattice.size_m" : elements ? "mesh.sizes_m" : size_m == study.indenter.half_width_m ? "indenter.half_width_m" : "loads.magnitudes_m", size_m);
    const std::string cure = g.unit_m == 1 ? ". Is this in millimetres? Then unit_m = 0.001" : fmt::format(": is the unit wrong, or is {} too short?", what.substr(0, what.find(' ')));
    if (!springs && !elements && size_m > 0 && longest_m > most_along * size_m)
        refuse(study, "geometry.unit_m", fmt::format("{}, more than {:g} times {}{}", length, most_along, what, cure));
    if (springs || elements) {
        const double along = longest_m / size_m, in_all = (sides_m / size_m).max(1.0).prod();
        if (along > most_along || in_all > most_in_all)
            refuse(study, "geometry.unit_m",
                   fmt::format("{}, which at {} is {:.2g} springs or elements; at most {:g} are possible{}", length, what,
                               std::max(along, in_all), most_in_all, cure));
        if (springs && along < 2)
            refuse(study, "geometry.unit_m", fmt::format("{}, less than two springs of {}: is the unit wrong, or are the springs too long?", length, what));
    }
    if (away_m > farthest * longest_m)
        refuse(study, "geometry.shape",
               fmt::format("{} and lies {:.3g} m from the origin, where coordinates have too few digits. Subtract ({:.6g}) from the coordinates in that file, and "
                           "({:.6g}) m from every contact_m of the study and of measured data",
                           length, away_m, fmt::join(middle.begin(), middle.end(), ", "), fmt::join(middle_m.begin(), middle_m.end(), ", ")));
}

std::string finer_than_asked(const Study& study, const Shape& shape) {
    constexpr double much = 0.4;
    if (!(study.spring_size_m > 0)) return "";
    const SpringMesh mesh = edge_mesh(shape);
    double sum_m = 0;
    for (Eigen::Index s = 0; s < mesh.springs.rows(); ++s) sum_m += (mesh.nodes.row(mesh.springs(s, 0)) - mesh.nodes.row(mesh.springs(s, 1))).norm();
    const double mean_m = sum_m / static_cast<double>(mesh.springs.rows());
    if (mean_m > much * study.spring_size_m) return "";
    return fmt::format("{} has an outline much finer than lattice.size_m = {:g} m: {} nodes, and springs {:.2g} mm long; every stage takes longer, and the tick may "
                       "take too long. Place its points farther apart",
                       study.geometry.shape, study.spring_size_m, mesh.nodes.rows(), 1e3 * mean_m);
}

void refuse_tool(const Study& study, const SpringMesh& mesh) {
    const Study::Indenter& tool = study.indenter;
    if (tool.kind == "patch") {
        const Eigen::VectorXd sides_m = (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).transpose();
        if (!(tool.half_width_m < 0.5 * sides_m.minCoeff()))
            refuse(study, "indenter.half_width_m", fmt::format("{:g} mm must be less than half of the tissue's shorter side, {:.4g} mm", 1e3 * tool.half_width_m, 1e3 * sides_m.minCoeff()));
    }
}

void refuse_push_through(const Study& study, const SpringMesh& mesh, const std::vector<PlannedPath>& paths) {
    constexpr double most = 0.1;  // allowed part of such paths: at the tip of a shape every indentation is one
    const double least_m = 1e-6 * (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).norm();
    std::size_t through = 0;
    std::string key, why;  // of the first such path
    bool needed = false;
    for (const PlannedPath& path : paths) {
        const Point inward = inward_at(mesh, path.push);
        double thick_m = std::numeric_limits<double>::infinity();
        for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
            const double t = along_to_facet(mesh, f, path.push.contact_m, inward);
            if (t > least_m) thick_m = std::min(thick_m, t);
        }
        const double depth_m = path.depth_m * path.push.direction.dot(inward);
        if (depth_m < thick_m) continue;
        ++through;
        if (!study.geometry.is_solid() && !study.loads.sweep && path.role == "train") needed = true;
        if (!why.empty()) continue;
        key = path.role == "map" ? "map.depth_m" : path.role == "train" || path.role == "check" ? std::string("loads.magnitudes_m") : "draws." + path.role + ".depth_m";
        why = fmt::format("load path '{}' has an indentation of {:.3g} mm at ({:.4g}) m, where the tissue is {:.3g} mm thick", path.push.name, 1e3 * depth_m,
                          fmt::join(path.push.contact_m.data(), path.push.contact_m.data() + path.push.contact_m.size(), ", "), 1e3 * thick_m);
    }
    if (needed || static_cast<double>(through) > most * static_cast<double>(paths.size()))
        refuse(study, key, fmt::format("{}; {} of {} load paths pass through the tissue", why, through, paths.size()));
}

void refuse_unknown_discs(const Study& study, const std::vector<PlannedPath>& paths) {
    if (study.indenter.kind != "disc") return;
    double least_m = std::numeric_limits<double>::infinity(), most_m = 0;
    for (const PlannedPath& path : paths) {
        if (path.role != "train") continue;
        least_m = std::min(least_m, path.push.radius_m);
        most_m = std::max(most_m, path.push.radius_m);
    }
    const auto check = [&](const std::string& key, double radius_m) {
        if (radius_m < least_m || radius_m > most_m)
            refuse(study, key, fmt::format("{:g} mm must be between the radii of the training contacts, {:g} and {:g} mm", 1e3 * radius_m, 1e3 * least_m, 1e3 * most_m));
    };
    check("indenter.radius_m", study.indenter.radius_m);
    for (const PlannedPath& path : paths)
        if (path.role != "train") check(fmt::format("draws.{}.radii_m", path.role), path.push.radius_m);
    for (const std::string& term : study.springs.terms)
        if (is_size_term(term) && !(least_m < most_m)) refuse(study, "springs.terms", fmt::format("'{}' needs training contacts with several radii, and all have {:g} mm", term, 1e3 * most_m));
}

}  // namespace tissue
