#include "mesh/held_region.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "error.h"
#include "mesh/surface.h"

namespace tissue {
namespace {

std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> words{""};
    for (const char c : text) {
        if (c == ' ' || c == '_' || c == '=') words.emplace_back();
        else words.back() += c;
    }
    words.erase(std::remove(words.begin(), words.end(), ""), words.end());
    return words;
}

std::optional<double> number(const std::string& word) {
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return {};
    return value;
}

/// Where an edge from inside to outside meets the border, as a part of it.
double border_on(const HeldRegion& region, const Eigen::Vector3d& inside_m, const Eigen::Vector3d& outside_m) {
    double low = 0, high = 1;
    for (int k = 0; k < 50; ++k) {
        const double middle = (low + high) / 2;
        (region.outside_m(inside_m + middle * (outside_m - inside_m)) < 0 ? low : high) = middle;
    }
    return high;
}

}  // namespace

std::optional<HeldRegion> HeldRegion::of(const std::string& text) {
    const std::vector<std::string> words = words_of(text);
    static const std::vector<std::string> kinds = {"below", "above", "ball", "box"};
    const auto kind = words.empty() ? kinds.end() : std::find(kinds.begin(), kinds.end(), words[0]);
    if (kind == kinds.end() || words.size() < 2) return {};
    std::vector<double> at;
    std::vector<std::string> others;  // what is no number
    for (auto word = words.begin() + 1; word != words.end(); ++word) {
        if (const auto value = number(*word)) at.push_back(*value);
        else others.push_back(*word);
    }
    const std::string word = fmt::format("{}", fmt::join(words, "_"));
    const auto along = [&](const Eigen::Vector3d& x, int axis) { return x[axis]; };
    if ((*kind == "below" || *kind == "above") && words.size() == 3 && others.size() == 1 && (others[0] == "x" || others[0] == "y" || others[0] == "z")) {
        const int axis = others[0][0] - 'x', sign = *kind == "below" ? 1 : -1;
        return HeldRegion(word, [=](const Eigen::Vector3d& x) { return sign * (along(x, axis) - at[0]); });
    }
    if (*kind == "ball" && words.size() == 6 && others == std::vector<std::string>{"radius"} && words[4] == "radius" && at[3] > 0) {
        const Eigen::Vector3d centre(at[0], at[1], at[2]);
        return HeldRegion(word, [=](const Eigen::Vector3d& x) { return (x - centre).norm() - at[3]; });
    }
    if (*kind == "box" && words.size() == 8 && others == std::vector<std::string>{"to"} && words[4] == "to") {
        const Eigen::Array3d low(at[0], at[1], at[2]), high(at[3], at[4], at[5]);
        if ((low < high).all()) return HeldRegion(word, [=](const Eigen::Vector3d& x) { return (low - x.array()).max(x.array() - high).maxCoeff(); });
    }
    throw MismatchError(fmt::format("'{}' is no region that holds; such are, in metres: below z = 0.01, above x = 0.1, ball 0.03 0.02 0.01 radius 0.015, box 0 0 0 to 0.1 0.05 0.01",
                                    text));
}

HeldParts held_parts(const std::vector<std::string>& texts) {
    HeldParts parts;
    for (const std::string& text : texts) {
        if (const auto region = HeldRegion::of(text)) parts.regions.push_back(*region);
        else parts.names.push_back(text);
    }
    return parts;
}

bool hold(Surface& s, const HeldRegion& region) {
    constexpr double least = 0.1;  // of a side: what is nearer is on the border
    std::vector<int> side(static_cast<std::size_t>(s.nodes.rows()));  // -1 inside, 1 outside, 0 on the border
    const auto place = [&](int node) { return Eigen::Vector3d(s.nodes.row(node).transpose()); };
    const auto sign = [](double x) { return (x > 0) - (x < 0); };
    for (std::size_t n = 0; n < side.size(); ++n) side[n] = sign(region.outside_m(place(static_cast<int>(n))));
    const std::vector<int> before = side;
    std::map<std::pair<int, int>, double> cut;  // nodes inside and outside: where between them
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
        for (int i = 0; i < 3; ++i) {
            const int a = s.triangles(t, i), b = s.triangles(t, (i + 1) % 3), in = before[static_cast<std::size_t>(a)] < 0 ? a : b, out = in == a ? b : a;
            if (before[static_cast<std::size_t>(in)] >= 0 || before[static_cast<std::size_t>(out)] <= 0 || cut.count({in, out})) continue;
            const double part = border_on(region, place(in), place(out));
            cut[{in, out}] = part;
            if (part < least) side[static_cast<std::size_t>(in)] = 0;
            if (part > 1 - least) side[static_cast<std::size_t>(out)] = 0;
        }
    std::map<std::pair<int, int>, int> added;
    std::vector<Eigen::Vector3d> places;
    const auto on_border = [&](int a, int b) {  // -1: it does not divide this side
        const int in = side[static_cast<std::size_t>(a)] < 0 ? a : b, out = in == a ? b : a;
        if (side[static_cast<std::size_t>(in)] >= 0 || side[static_cast<std::size_t>(out)] <= 0) return -1;
        const auto [there, fresh] = added.emplace(std::pair(in, out), static_cast<int>(s.nodes.rows()) + static_cast<int>(places.size()));
        if (fresh) places.push_back(place(in) + cut.at({in, out}) * (place(out) - place(in)));
        return there->second;
    };
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> label;
    bool held = false;
    const auto add = [&](const std::array<int, 3>& corners, int old, bool inside) {
        triangles.push_back(corners);
        label.push_back(inside ? Surface::fixed_label : old);
        held = held || inside;
    };
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
        const int old = s.label[static_cast<std::size_t>(t)];
        std::array<int, 3> corner{s.triangles(t, 0), s.triangles(t, 1), s.triangles(t, 2)};
        const auto of = [&](int k) { return side[static_cast<std::size_t>(corner[static_cast<std::size_t>(k)])]; };
        const int sum = of(0) + of(1) + of(2);
        if (!(std::min({of(0), of(1), of(2)}) < 0 && std::max({of(0), of(1), of(2)}) > 0)) {
            const bool border = of(0) == 0 && of(1) == 0 && of(2) == 0;
            add(corner, old, border ? region.outside_m((place(corner[0]) + place(corner[1]) + place(corner[2])) / 3) < 0 : sum < 0);
            continue;
        }
        // turned so that its first corner is alone on its side, or on the border
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
    const Eigen::Index N = s.nodes.rows();
    s.nodes.conservativeResize(N + static_cast<Eigen::Index>(places.size()), 3);
    for (std::size_t k = 0; k < places.size(); ++k) s.nodes.row(N + static_cast<Eigen::Index>(k)) = places[k].transpose();
    s.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) s.triangles.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1], triangles[t][2];
    s.label = label;
    return held;
}

}  // namespace tissue
