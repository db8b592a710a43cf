#include "mesh/fixed_region.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "error.h"
#include "mesh/spring_mesh.h"
#include "mesh/surface.h"
#include "mesh/surface_distance.h"

namespace tissue {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr Eigen::Index most_added = 500'000;

std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> words;
    bool open = false;
    for (const char c : text) {
        if (c == ' ' || c == '_' || c == '=' || c == '\t') {
            open = false;
            continue;
        }
        if (!open) words.emplace_back();
        words.back() += c;
        open = true;
    }
    return words;
}

std::optional<double> number(const std::string& word) {
    const char* begin = word.data() + (word.size() > 1 && word[0] == '+' ? 1 : 0);
    double value = 0;
    const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return {};
    return value;
}

/// The three numbers that begin at word `first`.
std::optional<Eigen::Vector3d> place_in(const std::vector<std::string>& words, std::size_t first) {
    Eigen::Vector3d place;
    for (std::size_t d = 0; d < 3; ++d) {
        const auto value = number(words[first + d]);
        if (!value) return {};
        place[static_cast<Eigen::Index>(d)] = *value;
    }
    return place;
}

/// Adds nodes to the surface and replaces its triangles.
void divide(Surface& s, const std::vector<Eigen::Vector3d>& added, const std::vector<std::array<int, 3>>& triangles, const std::vector<int>& label) {
    const Eigen::Index N = s.nodes.rows();
    s.nodes.conservativeResize(N + static_cast<Eigen::Index>(added.size()), 3);
    for (std::size_t k = 0; k < added.size(); ++k) s.nodes.row(N + static_cast<Eigen::Index>(k)) = added[k].transpose();
    s.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) s.triangles.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1], triangles[t][2];
    s.label = label;
}

/// Divides triangles that a region's border may cross, until no side is longer than side_m [m]. Neighbours are divided
/// with them, so that the surface stays closed.
void divide_near(Surface& s, const FixedRegion& region, double side_m) {
    const auto place = [&](int node) { return Eigen::Vector3d(s.nodes.row(node).transpose()); };
    using Side = std::pair<int, int>;
    const Eigen::Index given = s.triangles.rows();
    while (true) {
        std::map<Side, int> middle;  // new node of each side to be divided
        std::vector<Eigen::Vector3d> added;
        for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
            double longest_m = 0, nearest_m = std::numeric_limits<double>::infinity();
            Side longest;
            for (int i = 0; i < 3; ++i) {
                const Side side = std::minmax({s.triangles(t, i), s.triangles(t, (i + 1) % 3)});
                const double length_m = (place(side.first) - place(side.second)).norm();
                if (length_m > longest_m) {
                    longest_m = length_m;
                    longest = side;
                }
                nearest_m = std::min(nearest_m, std::abs(region.outside_m(place(s.triangles(t, i)))));
            }
            if (longest_m <= side_m || nearest_m > longest_m) continue;
            if (middle.emplace(longest, static_cast<int>(s.nodes.rows()) + static_cast<int>(added.size())).second) added.push_back((place(longest.first) + place(longest.second)) / 2);
        }
        if (middle.empty()) return;
        if (s.triangles.rows() - given + static_cast<Eigen::Index>(middle.size()) > most_added)
            throw MismatchError(fmt::format("'{}' would need more than {} new triangles near its border, as where triangles are long and thin; remesh the surface evenly first", region.text(), most_added));
        const auto middle_of = [&](int node) { return added[static_cast<std::size_t>(node - s.nodes.rows())]; };
        std::vector<std::array<int, 3>> triangles;
        std::vector<int> label;
        for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
            std::array<int, 3> c{s.triangles(t, 0), s.triangles(t, 1), s.triangles(t, 2)};
            const auto on = [&](int i) {  // new node on the side from corner i; -1: not divided
                const auto there = middle.find(std::minmax({c[static_cast<std::size_t>(i)], c[static_cast<std::size_t>((i + 1) % 3)]}));
                return there == middle.end() ? -1 : there->second;
            };
            const auto add = [&](int i, int j, int k) {
                triangles.push_back({i, j, k});
                label.push_back(s.label[static_cast<std::size_t>(t)]);
            };
            const int count = (on(0) >= 0) + (on(1) >= 0) + (on(2) >= 0);
            // rotated: one divided side is the first; two divided sides are the first two
            while ((count == 1 && on(0) < 0) || (count == 2 && on(2) >= 0)) std::rotate(c.begin(), c.begin() + 1, c.end());
            const int m = on(0), n = on(1), o = on(2);
            if (count == 0) {
                add(c[0], c[1], c[2]);
            } else if (count == 1) {
                add(c[0], m, c[2]);
                add(m, c[1], c[2]);
            } else if (count == 2) {
                add(m, c[1], n);
                if ((place(c[0]) - middle_of(n)).norm() <= (middle_of(m) - place(c[2])).norm()) {
                    add(c[0], m, n);
                    add(c[0], n, c[2]);
                } else {
                    add(c[0], m, c[2]);
                    add(m, n, c[2]);
                }
            } else {
                add(c[0], m, o);
                add(m, c[1], n);
                add(o, n, c[2]);
                add(m, n, o);
            }
        }
        divide(s, added, triangles, label);
    }
}

/// The point where an edge from inside to outside meets the border, as a fraction of the edge.
double border_on(const FixedRegion& region, const Eigen::Vector3d& inside_m, const Eigen::Vector3d& outside_m) {
    double low = 0, high = 1;
    for (int k = 0; k < 50; ++k) {
        const double middle = (low + high) / 2;
        (region.outside_m(inside_m + middle * (outside_m - inside_m)) < 0 ? low : high) = middle;
    }
    return high;
}

}  // namespace

std::optional<FixedRegion::Within> FixedRegion::within(const std::string& text) {
    constexpr std::string_view blanks = " \t";
    // three words, then the file's name, which may begin with a _; the one-word form has a single _ between words
    std::string words[3], left = text;
    for (std::string& word : words) {
        left.erase(0, left.find_first_not_of(blanks));
        const std::size_t end = std::min(left.find_first_of(" \t_"), left.size());
        word = left.substr(0, end);
        left.erase(0, end);
        if (!left.empty() && left[0] == '_') left.erase(0, 1);
    }
    left.erase(0, left.find_first_not_of(blanks));
    left.erase(left.find_last_not_of(blanks) + 1);
    const auto distance_m = number(words[1]);
    if (words[0] != "within" || words[2] != "of" || left.empty() || !distance_m || !(*distance_m > 0)) return {};
    return Within{words[1], left};
}

std::optional<FixedRegion> FixedRegion::of(const std::string& text, const Reader& read, double unit_m) {
    const std::vector<std::string> words = words_of(text);
    const std::string kind = words.empty() ? "" : words[0];
    const bool half = kind == "below" || kind == "above", spaced = text.find_first_of(" =\t") != std::string::npos;
    if (!half && kind != "ball" && kind != "box" && kind != "within") return {};
    const std::string joined = fmt::format("{}", fmt::join(words, " ")), word = fmt::format("{}", fmt::join(words, "_"));
    const bool along = half && words.size() > 1 && (words[1] == "x" || words[1] == "y" || words[1] == "z");
    if (!spaced && !along && (half || words.size() < 2 || !number(words[1]))) return {};
    if (along && words.size() == 3)
        if (const auto at = number(words[2])) {
            const int axis = words[1][0] - 'x', sign = kind == "below" ? 1 : -1;
            return FixedRegion(fmt::format("{} {} = {}", kind, words[1], words[2]), word, endless, [axis, sign, at = *at](const Eigen::Vector3d& x) { return sign * (x[axis] - at); });
        }
    if (kind == "ball" && words.size() == 6 && words[4] == "radius")
        if (const auto centre = place_in(words, 1))
            if (const auto r = number(words[5]); r && *r > 0) return FixedRegion(joined, word, 2 * *r, [c = *centre, r = *r](const Eigen::Vector3d& x) { return (x - c).norm() - r; });
    if (kind == "box" && words.size() == 8 && words[4] == "to") {
        const auto low = place_in(words, 1), high = place_in(words, 5);
        if (low && high && (low->array() < high->array()).all())
            return FixedRegion(joined, word, (*high - *low).minCoeff(), [low = low->array().eval(), high = high->array().eval()](const Eigen::Vector3d& x) { return (low - x.array()).max(x.array() - high).maxCoeff(); });
    }
    if (const auto parts = within(text)) {
        if (!read) throw MismatchError(fmt::format("'{}': a region within a distance of another surface is not possible here", text));
        const double most_m = *number(parts->distance_m);
        return FixedRegion(fmt::format("within {} of {}", parts->distance_m, parts->file), parts->word(), 2 * most_m,
                          [distance = SurfaceDistance(read(parts->file), unit_m), most_m](const Eigen::Vector3d& x) { return distance(x) - most_m; });
    }
    throw MismatchError(fmt::format("'{}' begins like a region of space but is not one; write regions in metres: below z = 0.01, above x = 0.1, ball 0.03 0.02 0.01 radius 0.015, "
                                    "box 0 0 0 to 0.1 0.05 0.01, within 0.003 of spine.stl",
                                    text));
}

double border_m(const NodeField& nodes) { return 1e-6 * size_m(nodes); }

FixedParts fixed_parts(const std::vector<std::string>& texts, const std::string& file, const FixedRegion::Reader& read, double unit_m, const std::vector<int>& beds) try {
    if (!beds.empty() && beds.size() != texts.size()) throw MismatchError(fmt::format("{} beds for {} fixed parts", beds.size(), texts.size()));
    FixedParts parts;
    for (std::size_t i = 0; i < texts.size(); ++i) {
        const int bed = beds.empty() ? 0 : beds[i];
        if (const auto region = FixedRegion::of(texts[i], read, unit_m)) {
            parts.regions.push_back(*region);
            parts.bed_of_region.push_back(bed);
        } else {
            parts.names.push_back(texts[i]);
            parts.bed_of_name.push_back(bed);
        }
    }
    return parts;
} catch (const MismatchError& e) {
    throw FileError(file + ": " + e.what());
}

bool hold(Surface& s, const FixedRegion& region, int fixed_label_of) {
    constexpr double finest = 40;      // refined sides: at most the longest side of the bounding box over this
    constexpr double narrowest = 130;  // width of a region: at least the longest side over this
    const double tiny_m = border_m(s.nodes), near_m = size_m(s.nodes) / 400, across_m = region.narrowest_m();
    if (across_m < size_m(s.nodes) / narrowest)
        throw MismatchError(fmt::format("'{}' is {:.3g} mm wide, less than 1/{:.0f} of the tissue's size", region.text(), 1e3 * across_m, narrowest));
    // a plane needs no refinement: it crosses a straight side at most once
    if (across_m < endless) divide_near(s, region, std::min(size_m(s.nodes) / finest, across_m / 3));
    std::vector<int> side(static_cast<std::size_t>(s.nodes.rows()));  // -1 inside, 1 outside, 0 on the border
    const auto place = [&](int node) { return Eigen::Vector3d(s.nodes.row(node).transpose()); };
    const auto sign = [&](double x) { return (x > tiny_m) - (x < -tiny_m); };
    for (std::size_t n = 0; n < side.size(); ++n) side[n] = sign(region.outside_m(place(static_cast<int>(n))));
    const std::vector<int> before = side;
    std::map<std::pair<int, int>, double> cut;  // (node inside, node outside): fraction of the side at the border
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
        for (int i = 0; i < 3; ++i) {
            const int a = s.triangles(t, i), b = s.triangles(t, (i + 1) % 3), in = before[static_cast<std::size_t>(a)] < 0 ? a : b, out = in == a ? b : a;
            if (before[static_cast<std::size_t>(in)] >= 0 || before[static_cast<std::size_t>(out)] <= 0 || cut.count({in, out})) continue;
            const double part = border_on(region, place(in), place(out));
            cut[{in, out}] = part;
            const double length_m = (place(in) - place(out)).norm();
            if (part * length_m < near_m) side[static_cast<std::size_t>(in)] = 0;
            if ((1 - part) * length_m < near_m) side[static_cast<std::size_t>(out)] = 0;
        }
    std::map<std::pair<int, int>, int> added;
    std::vector<Eigen::Vector3d> places;
    const auto on_border = [&](int a, int b) {  // new node on this side; -1: the border does not divide it
        const int in = side[static_cast<std::size_t>(a)] < 0 ? a : b, out = in == a ? b : a;
        if (side[static_cast<std::size_t>(in)] >= 0 || side[static_cast<std::size_t>(out)] <= 0) return -1;
        const auto [there, fresh] = added.emplace(std::pair(in, out), static_cast<int>(s.nodes.rows()) + static_cast<int>(places.size()));
        if (fresh) places.push_back(place(in) + cut.at({in, out}) * (place(out) - place(in)));
        return there->second;
    };
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> label;
    bool fixed = false;
    const auto add = [&](const std::array<int, 3>& corners, int old, bool inside) {
        triangles.push_back(corners);
        label.push_back(inside && !Surface::is_fixed(old) ? fixed_label_of : old);
        fixed = fixed || inside;
    };
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
        const int old = s.label[static_cast<std::size_t>(t)];
        std::array<int, 3> corner{s.triangles(t, 0), s.triangles(t, 1), s.triangles(t, 2)};
        const auto of = [&](int k) { return side[static_cast<std::size_t>(corner[static_cast<std::size_t>(k)])]; };
        const int sum = of(0) + of(1) + of(2);
        if (!(std::min({of(0), of(1), of(2)}) < 0 && std::max({of(0), of(1), of(2)}) > 0)) {
            const bool border = of(0) == 0 && of(1) == 0 && of(2) == 0;
            add(corner, old, border ? region.outside_m((place(corner[0]) + place(corner[1]) + place(corner[2])) / 3) <= tiny_m : sum < 0);
            continue;
        }
        // rotated: the first corner is on the border, or alone on its side of it
        while (!(of(0) == 0 || (of(1) != 0 && of(2) != 0 && of(1) == of(2) && of(0) != of(1)))) std::rotate(corner.begin(), corner.begin() + 1, corner.end());
        const auto [a, b, c] = corner;
        if (of(0) == 0) {
            const int m = on_border(b, c);
            add({a, b, m}, old, of(1) < 0);
            add({a, m, c}, old, of(2) < 0);
            continue;
        }
        const int p = on_border(a, b), q = on_border(c, a);
        add({a, p, q}, old, of(0) < 0);
        add({p, b, c}, old, of(1) < 0);
        add({p, c, q}, old, of(1) < 0);
    }
    divide(s, places, triangles, label);
    return fixed;
}

}  // namespace tissue
