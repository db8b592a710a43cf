#include "mesh/surface_report.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "error.h"

namespace tissue {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Edge = std::pair<int, int>;
using Kind = SurfaceFault::Kind;

constexpr std::size_t most_places = 3, most_crossings = 10'000;

class Surveyor {
   public:
    explicit Surveyor(const MshFile& mesh) : mesh_(mesh) {
        std::set<std::array<int, 3>> seen;
        for (const MshFile::Element& e : mesh.triangles) {
            std::array<int, 3> corners{e.node[0], e.node[1], e.node[2]}, key = corners;
            std::sort(key.begin(), key.end());
            if (seen.insert(key).second) triangles_.push_back(corners);  // an element in two groups is listed twice
        }
        if (triangles_.empty()) throw FileError(mesh.file + ": has no triangles");
        for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
            for (int i = 0; i < 3; ++i) {
                const int a = corner(t, i), b = corner(t, (i + 1) % 3);
                sides_[{std::min(a, b), std::max(a, b)}].push_back(a < b ? t : ~t);
            }
    }

    SurfaceReport report() {
        SurfaceReport r;
        measure(r);
        const bool closed = edges(r);
        orient(r);
        const std::size_t count = parts(r, closed);
        if (closed) handles(r, count);
        crossings(r);
        return r;
    }

   private:
    static int number_of(int in_sides) { return in_sides < 0 ? ~in_sides : in_sides; }
    int corner(int t, int i) const { return triangles_[static_cast<std::size_t>(t)][static_cast<std::size_t>(i)]; }
    Eigen::Vector3d place(int n) const {
        const MshFile::Point& p = mesh_.points[static_cast<std::size_t>(n)];
        return {p.x, p.y, p.z};
    }
    Eigen::Vector3d middle(int t) const { return (place(corner(t, 0)) + place(corner(t, 1)) + place(corner(t, 2))) / 3; }

    static void note(SurfaceReport& r, Kind kind, const Eigen::Vector3d& at) {
        const auto there = std::find_if(r.faults.begin(), r.faults.end(), [&](const SurfaceFault& f) { return f.kind == kind; });
        SurfaceFault& fault = there != r.faults.end() ? *there : r.faults.emplace_back(SurfaceFault{kind, 0, {}});
        ++fault.count;
        if (fault.first.size() < most_places) fault.first.push_back(at);
    }

    void measure(SurfaceReport& r) const {
        r.triangles = triangles_.size();
        constexpr double most = std::numeric_limits<double>::infinity();
        r.low = Eigen::Vector3d::Constant(most);
        r.high = -r.low;
        r.shortest = most;
        double sum = 0;
        std::vector<char> used(mesh_.points.size(), 0);
        for (int t = 0; t < static_cast<int>(r.triangles); ++t) {
            std::array<Eigen::Vector3d, 3> x;
            for (int i = 0; i < 3; ++i) {
                x[static_cast<std::size_t>(i)] = place(corner(t, i));
                used[static_cast<std::size_t>(corner(t, i))] = 1;
                r.low = r.low.cwiseMin(x[static_cast<std::size_t>(i)]);
                r.high = r.high.cwiseMax(x[static_cast<std::size_t>(i)]);
            }
            const double twice = (x[1] - x[0]).cross(x[2] - x[0]).norm();
            std::array<double, 3> side;
            for (std::size_t i = 0; i < 3; ++i) {
                side[i] = (x[(i + 1) % 3] - x[i]).norm();
                sum += side[i];
            }
            std::sort(side.begin(), side.end());
            r.shortest = std::min(r.shortest, side[0]);
            r.area += twice / 2;
            if (!(twice > 1e-12 * side[2] * side[2])) note(r, Kind::flat, middle(t));
            // the smallest angle is between the two longest sides
            else if (twice / (side[1] * side[2]) < std::sin(sliver_angle_deg * 3.14159265358979 / 180)) ++r.slivers;
        }
        r.mean = sum / (3 * static_cast<double>(r.triangles));
        r.points = static_cast<std::size_t>(std::count(used.begin(), used.end(), 1));
    }

    /// Notes holes and non-manifold edges. Result: whether every edge has exactly two triangles.
    bool edges(SurfaceReport& r) const {
        std::map<int, std::vector<int>> open;  // neighbours of each point along sides with one triangle only
        for (const auto& [edge, triangles] : sides_) {
            const Eigen::Vector3d at = (place(edge.first) + place(edge.second)) / 2;
            if (triangles.size() > 2) note(r, Kind::crowded, at);
            if (triangles.size() != 1) continue;
            open[edge.first].push_back(edge.second);
            open[edge.second].push_back(edge.first);
        }
        std::map<int, char> seen;
        double longest = 0;
        for (const auto& [first, ends] : open) {  // each connected set is one hole
            if (seen[first]) continue;
            std::vector<int> next{first};
            seen[first] = 1;
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            double count = 0, length = 0;
            while (!next.empty()) {
                const int n = next.back();
                next.pop_back();
                sum += place(n);
                ++count;
                for (int other : open.at(n)) {
                    length += (place(other) - place(n)).norm() / 2;
                    if (!seen[other]) next.push_back(other);
                    seen[other] = 1;
                }
            }
            note(r, Kind::holes, sum / count);
            longest = std::max(longest, length);
        }
        for (SurfaceFault& fault : r.faults)
            if (fault.kind == Kind::holes) fault.largest = longest;
        return open.empty() && std::none_of(r.faults.begin(), r.faults.end(), [](const SurfaceFault& f) { return f.kind == Kind::crowded; });
    }

    /// Finds the triangles to turn so that each part's normals point out, as mesh/surface.cpp turns them. Notes edges
    /// where this is impossible.
    void orient(SurfaceReport& r) {
        turn_.assign(triangles_.size(), 0);
        // neighbours, and whether both run the edge in the same direction
        std::vector<std::vector<std::pair<int, bool>>> across(triangles_.size());
        for (const auto& [edge, triangles] : sides_) {
            if (triangles.size() != 2) continue;
            const bool same = (triangles[0] < 0) == (triangles[1] < 0);
            const int s = number_of(triangles[0]), t = number_of(triangles[1]);
            across[static_cast<std::size_t>(s)].emplace_back(t, same);
            across[static_cast<std::size_t>(t)].emplace_back(s, same);
        }
        std::vector<char> seen(triangles_.size(), 0);
        for (int first = 0; first < static_cast<int>(triangles_.size()); ++first) {
            if (seen[static_cast<std::size_t>(first)]) continue;
            std::vector<int> part{first};
            seen[static_cast<std::size_t>(first)] = 1;
            double six = 0;
            for (std::size_t k = 0; k < part.size(); ++k) {
                const int t = part[k];
                six += six_volumes(t, place(corner(first, 0)));
                for (const auto& [other, same] : across[static_cast<std::size_t>(t)]) {
                    const char turn = turn_[static_cast<std::size_t>(t)] != static_cast<char>(same);
                    if (!seen[static_cast<std::size_t>(other)]) {
                        seen[static_cast<std::size_t>(other)] = 1;
                        turn_[static_cast<std::size_t>(other)] = turn;
                        part.push_back(other);
                    } else if (turn_[static_cast<std::size_t>(other)] != turn && t < other) {
                        note(r, Kind::one_sided, (middle(t) + middle(other)) / 2);
                    }
                }
            }
            for (int t : part) {
                if (six < 0) turn_[static_cast<std::size_t>(t)] = !turn_[static_cast<std::size_t>(t)];
                r.turned += static_cast<std::size_t>(turn_[static_cast<std::size_t>(t)]);
            }
        }
    }

    /// Six times the signed volume of the tetrahedron from origin to a triangle.
    double six_volumes(int t, const Eigen::Vector3d& origin) const {
        const double six = (place(corner(t, 0)) - origin).dot((place(corner(t, 1)) - origin).cross(place(corner(t, 2)) - origin));
        return turn_[static_cast<std::size_t>(t)] ? -six : six;
    }

    /// Notes the connected parts besides the largest, and sets the volume. Result: number of parts.
    std::size_t parts(SurfaceReport& r, bool closed) {
        boost::disjoint_sets_with_storage<> part(triangles_.size());
        for (const auto& [edge, triangles] : sides_)
            for (int t : triangles) part.union_set(number_of(t), number_of(triangles[0]));
        struct Part {
            double six = 0, size = 0;
            Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
        };
        std::map<std::size_t, Part> all;
        const Eigen::Vector3d origin = place(corner(0, 0));
        for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
            Part& p = all[part.find_set(static_cast<std::size_t>(t))];
            const Eigen::Vector3d a = place(corner(t, 0)), b = place(corner(t, 1)), c = place(corner(t, 2));
            p.six += six_volumes(t, origin);
            p.low = p.low.cwiseMin(a).cwiseMin(b).cwiseMin(c);
            p.high = p.high.cwiseMax(a).cwiseMax(b).cwiseMax(c);
        }
        std::vector<Part> order;
        for (auto& [key, p] : all) {
            p.size = (p.high - p.low).maxCoeff();
            order.push_back(p);
        }
        std::stable_sort(order.begin(), order.end(), [](const Part& a, const Part& b) { return a.size > b.size; });
        for (std::size_t k = 1; k < order.size(); ++k) {
            note(r, Kind::parts, (order[k].low + order[k].high) / 2);
            if (k == 1) r.faults.back().largest = order[k].size;
        }
        if (closed) r.volume = std::abs(order.front().six) / 6;
        return order.size();
    }

    /// For a closed surface: notes points with more than one fan of triangles, and the handles by Euler's number:
    /// points - edges + triangles = 2 parts - 2 handles. Each fan counts as a point of its own.
    void handles(SurfaceReport& r, std::size_t parts) const {
        boost::disjoint_sets_with_storage<> fan(3 * triangles_.size());
        const auto at = [&](int t, int n) { return static_cast<std::size_t>(3 * t + (corner(t, 0) == n ? 0 : corner(t, 1) == n ? 1 : 2)); };
        for (const auto& [edge, triangles] : sides_)
            for (int n : {edge.first, edge.second}) fan.union_set(at(number_of(triangles[0]), n), at(number_of(triangles[1]), n));
        std::map<int, int> fans;  // number of fans at each point
        long count = 0;
        for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
            for (int i = 0; i < 3; ++i)
                if (const auto k = static_cast<std::size_t>(3 * t + i); fan.find_set(k) == k) {
                    ++count;
                    if (++fans[corner(t, i)] == 2) note(r, Kind::pinched, place(corner(t, i)));
                }
        const long euler = count - static_cast<long>(sides_.size()) + static_cast<long>(triangles_.size()), lacking = 2 * static_cast<long>(parts) - euler;
        if (lacking > 0) r.faults.push_back({Kind::handles, static_cast<std::size_t>((lacking + 1) / 2), {}});
    }

    /// Whether two triangles intersect beyond their common corners and side.
    bool cut(int s, int t) const {
        std::vector<int> common, of_s, of_t;
        for (int i = 0; i < 3; ++i) {
            const bool both = corner(s, i) == corner(t, 0) || corner(s, i) == corner(t, 1) || corner(s, i) == corner(t, 2);
            (both ? common : of_s).push_back(corner(s, i));
        }
        for (int i = 0; i < 3; ++i)
            if (std::find(common.begin(), common.end(), corner(t, i)) == common.end()) of_t.push_back(corner(t, i));
        const auto point = [&](int n) {
            const MshFile::Point& p = mesh_.points[static_cast<std::size_t>(n)];
            return Kernel::Point_3(p.x, p.y, p.z);
        };
        // no intersection if one triangle, except for the common corner, is on one side of the other's plane (a fan)
        if (common.size() == 1) {
            const auto beside = [&](int k, const std::vector<int>& others) {
                const auto side = [&](int n) { return CGAL::orientation(point(corner(k, 0)), point(corner(k, 1)), point(corner(k, 2)), point(n)); };
                return side(others[0]) != CGAL::COPLANAR && side(others[0]) == side(others[1]);
            };
            if (beside(t, of_s) || beside(s, of_t)) return false;
        }
        const auto triangle = [&](int k) { return Kernel::Triangle_3(point(corner(k, 0)), point(corner(k, 1)), point(corner(k, 2))); };
        const Kernel::Triangle_3 first = triangle(s), second = triangle(t);
        if (first.is_degenerate() || second.is_degenerate()) return false;  // reported as flat
        if (common.size() == 2) {  // intersect if folded onto each other
            const auto a = point(common[0]), b = point(common[1]), c = point(of_s[0]), d = point(of_t[0]);
            return CGAL::coplanar(a, b, c, d) && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
        }
        if (common.empty()) return CGAL::do_intersect(first, second);
        // one common corner: they intersect if a side opposite to it meets the other triangle
        return CGAL::do_intersect(second, Kernel::Segment_3(point(of_s[0]), point(of_s[1]))) || CGAL::do_intersect(first, Kernel::Segment_3(point(of_t[0]), point(of_t[1])));
    }

    void crossings(SurfaceReport& r) const {
        struct Box : CGAL::Box_intersection_d::Box_d<double, 3> {
            using Base = CGAL::Box_intersection_d::Box_d<double, 3>;
            Box(const CGAL::Bbox_3& box, int of) : Base(box), triangle(of) {}
            int triangle;
        };
        std::vector<Box> boxes;
        for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
            CGAL::Bbox_3 box;
            for (int i = 0; i < 3; ++i) {
                const Eigen::Vector3d x = place(corner(t, i));
                box += CGAL::Bbox_3(x.x(), x.y(), x.z(), x.x(), x.y(), x.z());
            }
            boxes.emplace_back(box, t);
        }
        std::vector<std::pair<int, int>> pairs;
        struct Enough {};
        try {
            CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
                if (!cut(a.triangle, b.triangle)) return;
                pairs.emplace_back(std::minmax(a.triangle, b.triangle));
                if (pairs.size() == most_crossings) throw Enough();
            });
        } catch (const Enough&) {
        }
        std::sort(pairs.begin(), pairs.end());
        for (const auto& [s, t] : pairs) note(r, Kind::crossings, (middle(s) + middle(t)) / 2);
    }

    const MshFile& mesh_;
    std::vector<std::array<int, 3>> triangles_;
    std::vector<char> turn_;
    std::map<Edge, std::vector<int>> sides_;  // triangles t of each edge; ~t if t runs it from higher to lower point
};

}  // namespace

SurfaceReport report_on(const MshFile& mesh) { return Surveyor(mesh).report(); }

const char* fault_name(Kind kind) {
    switch (kind) {
        case Kind::holes: return "holes";
        case Kind::crowded: return "non_manifold_edges";
        case Kind::one_sided: return "one_sided";
        case Kind::pinched: return "pinched";
        case Kind::crossings: return "crossings";
        case Kind::parts: return "parts";
        case Kind::handles: return "through_holes";
        case Kind::flat: return "without_area";
    }
    return "";
}

std::string fault_text(const SurfaceFault& fault, const std::string& unit, double factor) {
    const auto said = [&](const char* one, const char* many) { return fmt::format("{} {}", fault.count, fault.count == 1 ? one : many); };
    std::string line;
    switch (fault.kind) {
        case Kind::holes: line = fmt::format("{}, {}perimeter {:.3g}{}", said("hole", "holes"), fault.count == 1 ? "" : "longest ", factor * fault.largest, unit); break;
        case Kind::crowded: line = said("edge", "edges") + " shared by more than two triangles"; break;
        case Kind::one_sided: line = said("edge", "edges") + " where inside and outside are not distinct"; break;
        case Kind::pinched: line = said("point", "points") + " where the surface touches itself"; break;
        case Kind::crossings: line = fmt::format("{}{} of triangles that intersect", fault.count == most_crossings ? "at least " : "", said("pair", "pairs")); break;
        case Kind::parts: line = fmt::format("{} besides the largest, {}{:.3g}{} wide", said("part", "parts"), fault.count == 1 ? "" : "the next ", factor * fault.largest, unit); break;
        case Kind::handles: line = said("hole", "holes") + " through the tissue (as of a ring), which are not supported"; break;
        case Kind::flat: line = said("triangle", "triangles") + " without area"; break;
    }
    std::vector<std::string> places;
    for (const Eigen::Vector3d& at : fault.first) places.push_back(fmt::format("({:.6g}, {:.6g}, {:.6g})", at.x(), at.y(), at.z()));
    if (!places.empty()) line += fmt::format("; {} {}{}", fault.count > fault.first.size() ? "the first at" : "at", fmt::join(places, ", "), fault.count > fault.first.size() ? ", .." : "");
    return line;
}

}  // namespace tissue
