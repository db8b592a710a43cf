#include "mesh/stl_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>
#include <unordered_map>

#include "error.h"
#include "io/atomic_file.h"

namespace tissue {
namespace {

constexpr double largest_coordinate = 1e12;  // as read_msh has it
constexpr std::size_t most_facets = 1'000'000;
constexpr double same_point = 1e-8;  // of the extent's diagonal
constexpr std::size_t binary_head = 84, binary_facet = 50;

/// Facets before their corners are points of a mesh.
struct Facets {
    std::vector<std::array<MshFile::Point, 3>> corners;
    std::vector<int> solid;          // of each, from 1
    std::vector<std::string> names;  // of the solids; empty: none
};

constexpr std::string_view blanks = " \t\r\v\f";

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// The first word of a text, which goes on behind it.
std::string_view take_word(std::string_view& text) {
    text = trimmed(text);
    const std::string_view word = text.substr(0, text.find_first_of(blanks));
    text.remove_prefix(word.size());
    return word;
}

bool is_word(std::string_view text, std::string_view lower) {
    return text.size() == lower.size() && std::equal(text.begin(), text.end(), lower.begin(), [](unsigned char a, char b) { return std::tolower(a) == b; });
}

bool usable(const MshFile::Point& p) {
    return std::isfinite(p.x + p.y + p.z) && std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= largest_coordinate;
}

class AsciiReader {
   public:
    AsciiReader(const std::string& file, std::string_view text) : file_(file), text_(text) {}

    Facets read() {
        for (std::string_view line = next(); !line.empty(); line = next()) {
            const std::string_view word = take_word(line);
            if (is_word(word, "solid")) {
                if (open_) refuse("a solid begins where 'endsolid' should stand");
                facets_.names.emplace_back(trimmed(line));
                open_ = true;
            } else if (is_word(word, "endsolid")) {
                if (!open_) refuse("'endsolid' stands where no solid has begun");
                open_ = false;
            } else if (is_word(word, "facet") && open_) {
                facet();
            } else {
                refuse(open_ ? "is neither 'facet' nor 'endsolid'" : "is not 'solid'");
            }
        }
        if (open_) throw FileError(file_ + ": breaks off: 'endsolid' is missing");
        return std::move(facets_);
    }

   private:
    void facet() {
        want("outer", "outer loop");
        std::array<MshFile::Point, 3> corners;
        for (MshFile::Point& p : corners) {
            std::string_view line = want("vertex", "vertex x y z");
            for (double* value : {&p.x, &p.y, &p.z}) {
                std::string_view word = take_word(line);
                if (!word.empty() && word.front() == '+') word.remove_prefix(1);
                const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), *value);
                if (error != std::errc() || end != word.data() + word.size()) refuse("is not 'vertex x y z'");
            }
            if (!trimmed(line).empty()) refuse("is not 'vertex x y z'");
            if (!usable(p)) refuse(fmt::format("has a coordinate that is no finite number, or beyond {:g}", largest_coordinate));
        }
        want("endloop", "endloop");
        want("endfacet", "endfacet");
        if (facets_.corners.size() == most_facets) refuse(fmt::format("is facet {}; at most {} are read", most_facets + 1, most_facets));
        facets_.corners.push_back(corners);
        facets_.solid.push_back(static_cast<int>(facets_.names.size()));
    }

    /// The next line that is not blank; empty at the end of the file.
    std::string_view next() {
        while (!text_.empty()) {
            const std::size_t end = std::min(text_.find('\n'), text_.size());
            const std::string_view line = trimmed(text_.substr(0, end));
            text_.remove_prefix(std::min(end + 1, text_.size()));
            ++number_;
            if (!line.empty()) return line;
        }
        return {};
    }

    /// What follows the word with which the next line has to begin.
    std::string_view want(std::string_view word, const char* whole) {
        std::string_view line = next();
        if (line.empty()) throw FileError(fmt::format("{}: breaks off where '{}' should stand", file_, whole));
        if (!is_word(take_word(line), word)) refuse(fmt::format("is not '{}'", whole));
        return line;
    }

    [[noreturn]] void refuse(const std::string& why) const { throw FileError(fmt::format("{}:{}: {}", file_, number_, why)); }

    const std::string& file_;
    std::string_view text_;
    long number_ = 0;
    bool open_ = false;
    Facets facets_;
};

std::uint32_t little_endian(const char* bytes) {
    std::uint32_t value = 0;
    for (int k = 3; k >= 0; --k) value = value << 8 | static_cast<unsigned char>(bytes[k]);
    return value;
}

float little_endian_float(const char* bytes) {
    const std::uint32_t bits = little_endian(bytes);
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

Facets read_binary(const std::string& file, std::string_view bytes) {
    if (bytes.size() < binary_head) throw FileError(file + ": is no .stl: it neither begins with 'solid' nor has the 84 bytes with which a binary one begins");
    const std::uint32_t count = little_endian(&bytes[binary_head - 4]);
    if (count > most_facets && bytes.size() > binary_head + binary_facet * most_facets)
        throw FileError(fmt::format("{}: has {} facets; at most {} are read", file, count, most_facets));
    if (binary_head + binary_facet * count > bytes.size())  // some programs write something behind; of a text these four bytes are far too many
        throw FileError(fmt::format("{}: is cut off, or no .stl: as a binary one it says that it has {} facets, which take {} bytes; it has {}", file, count,
                                    binary_head + binary_facet * std::size_t{count}, bytes.size()));
    Facets facets;
    facets.names.emplace_back();
    facets.solid.assign(count, 1);
    facets.corners.resize(count);
    for (std::size_t f = 0; f < count; ++f) {
        const char* corner = &bytes[binary_head + binary_facet * f] + 12;  // behind the normal
        for (MshFile::Point& p : facets.corners[f]) {
            p = {little_endian_float(corner), little_endian_float(corner + 4), little_endian_float(corner + 8)};
            corner += 12;
            if (!usable(p)) throw FileError(fmt::format("{}: facet {} has a coordinate that is no finite number, or beyond {:g}", file, f + 1, largest_coordinate));
        }
    }
    return facets;
}

/// Whether the text goes on as ASCII after a first line with `solid`: a binary file's head may begin with that word too.
bool is_ascii(std::string_view text) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\v\f\n"), text.size()));
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view first = text.substr(0, end), rest = text.substr(std::min(end + 1, text.size()));
    if (!is_word(take_word(first), "solid") || first.find('\0') != std::string_view::npos) return false;
    const std::size_t next = rest.find_first_not_of(" \t\r\v\f\n");
    if (next == std::string_view::npos) return true;
    std::string_view line = rest.substr(next, 20);
    line = line.substr(0, line.find('\n'));
    const std::string_view word = take_word(line);
    return is_word(word, "facet") || is_word(word, "endsolid");
}

/// Points that are one where they are nearer to each other than a tolerance along every axis.
class Points {
   public:
    Points(const Facets& facets, std::vector<MshFile::Point>& points) : points_(points) {
        constexpr double most = std::numeric_limits<double>::infinity();
        MshFile::Point high{-most, -most, -most};
        low_ = {most, most, most};
        for (const auto& corners : facets.corners)
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
        if (!(tolerance_ > 0) && !points_.empty()) return 0;  // all are one
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

bool is_stl(const std::string& file) {
    return file.size() > 4 && is_word(std::string_view(file).substr(file.size() - 4), ".stl");
}

MshFile read_stl(const std::string& file) {
    const std::string content = read_file(file);
    std::string_view text = content;
    if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);  // the mark of UTF-8
    const Facets facets = is_ascii(text) ? AsciiReader(file, text).read() : read_binary(file, content);
    MshFile mesh;
    mesh.file = file;
    const bool grouped = facets.names.size() > 1 && std::any_of(facets.names.begin(), facets.names.end(), [](const std::string& n) { return !n.empty(); });
    for (std::size_t k = 0; grouped && k < facets.names.size(); ++k)
        mesh.triangle_names[static_cast<int>(k) + 1] = facets.names[k].empty() ? std::to_string(k + 1) : facets.names[k];
    Points points(facets, mesh.points);
    for (std::size_t f = 0; f < facets.corners.size(); ++f) {
        MshFile::Element e{static_cast<long>(f) + 1, {}, grouped ? facets.solid[f] : 0};
        for (int i = 0; i < 3; ++i) e.node[i] = points.place_of(facets.corners[f][static_cast<std::size_t>(i)]);
        if (e.node[0] != e.node[1] && e.node[1] != e.node[2] && e.node[2] != e.node[0]) mesh.triangles.push_back(e);
    }
    if (mesh.triangles.empty()) throw FileError(file + ": has no facets");
    return mesh;
}

MshFile read_surface_file(const std::string& file, const std::string& named) {
    return is_stl(file) ? read_stl(file) : read_msh(file, true, named);
}

}  // namespace tissue
