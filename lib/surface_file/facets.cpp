#include "surface_file/facets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "error.h"
#include "surface_file/divide_facet.h"

namespace tissue::surface_file {
namespace {

constexpr double same_point = 1e-8;  // tolerance over the diagonal of the bounding box
constexpr std::size_t most_divided = 1'000'000'000;  // sum of corners^3; dividing them takes some twenty seconds

bool usable(const MshFile::Point& p) {
    return std::isfinite(p.x + p.y + p.z) && std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= largest_coordinate;
}

/// Merges points that differ by at most a tolerance along every axis: each becomes the first such point. A hash grid
/// with boxes of the tolerance finds the candidates.
class Points {
   public:
    Points(const std::vector<std::array<MshFile::Point, 3>>& facets, std::vector<MshFile::Point>& points) : points_(points) {
        constexpr double most = std::numeric_limits<double>::infinity();
        MshFile::Point high{-most, -most, -most};
        low_ = {most, most, most};
        for (const auto& corners : facets)
            for (const MshFile::Point& p : corners) {
                low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y), std::min(low_.z, p.z)};
                high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
            }
        tolerance_ = same_point * std::hypot(high.x - low_.x, high.y - low_.y, high.z - low_.z);
    }

    int place_of(const MshFile::Point& p) {
        if (!(tolerance_ > 0)) return first_or_new(p, {});
        const Box box{box_along(p.x - low_.x), box_along(p.y - low_.y), box_along(p.z - low_.z)};
        int found = -1;
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                for (int k = -1; k <= 1; ++k) {
                    const auto there = in_box_.find({box[0] + i, box[1] + j, box[2] + k});
                    if (there == in_box_.end()) continue;
                    for (int place : there->second)
                        if ((found < 0 || place < found) && near(points_[static_cast<std::size_t>(place)], p)) found = place;
                }
        return found >= 0 ? found : first_or_new(p, box);
    }

   private:
    using Box = std::array<std::int64_t, 3>;
    struct Hash {
        std::size_t operator()(const Box& b) const {
            return static_cast<std::size_t>(b[0]) * 73856093u ^ static_cast<std::size_t>(b[1]) * 19349663u ^ static_cast<std::size_t>(b[2]) * 83492791u;
        }
    };

    std::int64_t box_along(double x) const { return static_cast<std::int64_t>(std::floor(x / tolerance_)); }

    bool near(const MshFile::Point& a, const MshFile::Point& b) const {
        return std::abs(a.x - b.x) <= tolerance_ && std::abs(a.y - b.y) <= tolerance_ && std::abs(a.z - b.z) <= tolerance_;
    }

    int first_or_new(const MshFile::Point& p, const Box& box) {
        if (!(tolerance_ > 0) && !points_.empty()) return 0;  // all points are equal
        points_.push_back(p);
        in_box_[box].push_back(static_cast<int>(points_.size()) - 1);
        return static_cast<int>(points_.size()) - 1;
    }

    std::vector<MshFile::Point>& points_;
    MshFile::Point low_{};
    double tolerance_ = 0;
    std::unordered_map<Box, std::vector<int>, Hash> in_box_;
};

}  // namespace

std::string_view without_mark(std::string_view text) {
    if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);
    return text;
}

void Facets::begin_group(const std::string& name) {
    names_.push_back(name);
    now_ = static_cast<int>(names_.size());
}

void Facets::refuse(const std::string& why, long line) const {
    throw FileError(line > 0 ? fmt::format("{}:{}: {}", file_, line, why) : fmt::format("{}: facet {} {}", file_, given_, why));
}

void Facets::add(const std::array<MshFile::Point, 3>& corners) {
    ++given_;
    add_triangle(corners, 0);
}

void Facets::add_triangle(const std::array<MshFile::Point, 3>& corners, long line) {
    if (corners_.size() == most_facets) throw FileError(fmt::format("{}: has more than {} facets; this is the most that is read", file_, most_facets));
    for (const MshFile::Point& p : corners)
        if (!usable(p)) refuse(fmt::format("has a coordinate that is not a finite number, or beyond {:g}", largest_coordinate), line);
    corners_.push_back(corners);
    group_.push_back(now_);
}

void Facets::add(const std::vector<MshFile::Point>& points, const std::vector<long long>& of_points, long line) {
    ++given_;
    if (of_points.size() < 3 || of_points.size() > most_corners) refuse(fmt::format("has {} corners; a facet must have 3 to {}", of_points.size(), most_corners), line);
    std::vector<MshFile::Point> polygon;
    const auto same = [](const MshFile::Point& a, const MshFile::Point& b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
    for (const long long there : of_points) {
        if (there < 0 || there >= static_cast<long long>(points.size())) refuse(fmt::format("names a point that the file does not have; it has {} points", points.size()), line);
        const MshFile::Point& p = points[static_cast<std::size_t>(there)];
        if (!usable(p)) refuse(fmt::format("has a coordinate that is not a finite number, or beyond {:g}", largest_coordinate), line);
        // some programs write a triangle as a quadrilateral with one corner twice
        if (polygon.empty() || !same(polygon.back(), p)) polygon.push_back(p);
    }
    while (polygon.size() > 1 && same(polygon.front(), polygon.back())) polygon.pop_back();
    if (polygon.size() < 3) return;
    if (polygon.size() == 3) return add_triangle({polygon[0], polygon[1], polygon[2]}, line);
    divided_ += polygon.size() * polygon.size() * polygon.size();
    if (divided_ > most_divided) refuse("exceeds the limit for facets with many corners", line);
    const auto triangles = divide_facet(polygon);
    if (triangles.size() != polygon.size() - 2) refuse("cannot be divided into triangles", line);
    for (const auto& t : triangles) add_triangle({polygon[t[0]], polygon[t[1]], polygon[t[2]]}, line);
}

MshFile Facets::mesh() const {
    MshFile mesh;
    mesh.file = file_;
    std::vector<bool> used(names_.size(), false), named = used;
    for (int k : group_) {
        used[static_cast<std::size_t>(k - 1)] = true;
        named[static_cast<std::size_t>(k - 1)] = !names_[static_cast<std::size_t>(k - 1)].empty();
    }
    const bool grouped = std::count(used.begin(), used.end(), true) > 1 && std::count(named.begin(), named.end(), true) > 0;
    for (std::size_t k = 0; grouped && k < names_.size(); ++k) {
        if (!used[k]) continue;
        const std::string number = std::to_string(k + 1);
        if (!named[k] && std::find(names_.begin(), names_.end(), number) != names_.end())
            throw FileError(fmt::format("{0}: its part {1} has no name, and another part has the name '{1}': give every part a name", file_, number));
        mesh.triangle_names[static_cast<int>(k) + 1] = named[k] ? names_[k] : number;
    }
    Points points(corners_, mesh.points);
    for (std::size_t f = 0; f < corners_.size(); ++f) {
        MshFile::Element e{static_cast<long>(f) + 1, {}, grouped ? group_[f] : 0};
        for (int i = 0; i < 3; ++i) e.node[i] = points.place_of(corners_[f][static_cast<std::size_t>(i)]);
        if (e.node[0] != e.node[1] && e.node[1] != e.node[2] && e.node[2] != e.node[0]) mesh.triangles.push_back(e);
    }
    if (mesh.triangles.empty()) throw FileError(file_ + ": has no facets");
    return mesh;
}

}  // namespace tissue::surface_file
