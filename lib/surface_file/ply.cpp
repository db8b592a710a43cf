#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

#include "error.h"
#include "surface_file/facets.h"
#include "surface_file/text_lines.h"

namespace tissue::surface_file {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr struct {
    std::string_view name, also;
    Type type;
    std::size_t bytes;
} types[] = {{"char", "int8", Type::int8, 1},      {"uchar", "uint8", Type::uint8, 1},    {"short", "int16", Type::int16, 2},    {"ushort", "uint16", Type::uint16, 2},
             {"int", "int32", Type::int32, 4},     {"uint", "uint32", Type::uint32, 4},   {"float", "float32", Type::float32, 4}, {"double", "float64", Type::float64, 8}};

constexpr std::size_t most_properties = 1000;

struct Property {
    std::string name;
    Type type;
    std::optional<Type> length;  // type of a list's length; none: a single value
};

struct Element {
    std::string name;
    long long count = 0;
    std::vector<Property> properties;
    bool is(std::string_view one, std::string_view many) const { return name == one || name == many; }
};

/// Takes value after value from an ASCII file or from either binary kind.
class Values {
   public:
    enum class Kind { ascii, little, big };
    Values(const std::string& file, TextLines& lines, Kind kind) : file_(file), lines_(lines), kind_(kind), bytes_(lines.rest()) {}

    void begin_item() {
        if (kind_ == Kind::ascii) line_ = lines_.want("the values of an element");
    }
    double take(Type type) {
        if (kind_ == Kind::ascii) return lines_.take_real(line_, "as many numbers as the element has");
        const std::size_t size = types[static_cast<std::size_t>(type)].bytes;
        if (bytes_.size() - at_ < size) throw FileError(fmt::format("{}: is truncated within an element, {} bytes after its header", file_, at_));
        std::array<char, 8> raw{};
        std::memcpy(raw.data(), bytes_.data() + at_, size);
        at_ += size;
        if (kind_ == Kind::big) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
        const auto as = [&](auto value) {
            std::memcpy(&value, raw.data(), sizeof value);
            return static_cast<double>(value);
        };
        switch (type) {
            case Type::int8: return as(std::int8_t{});
            case Type::uint8: return as(std::uint8_t{});
            case Type::int16: return as(std::int16_t{});
            case Type::uint16: return as(std::uint16_t{});
            case Type::int32: return as(std::int32_t{});
            case Type::uint32: return as(std::uint32_t{});
            case Type::float32: return as(float{});
            case Type::float64: return as(double{});
        }
        return 0;
    }
    long line() const { return kind_ == Kind::ascii ? lines_.number() : 0; }

   private:
    const std::string& file_;
    TextLines& lines_;
    Kind kind_;
    std::string_view bytes_, line_;
    std::size_t at_ = 0;
};

Type type_of(std::string_view word, const TextLines& lines) {
    for (const auto& type : types)
        if (word == type.name || word == type.also) return type.type;
    lines.refuse(fmt::format("'{}' is not a number type of .ply", word));
}

struct Head {
    std::vector<Element> elements;
    Values::Kind kind = Values::Kind::ascii;
};

Head read_head(TextLines& lines) {
    if (lines.want("ply") != "ply") lines.refuse("is not a .ply: it does not begin with 'ply'");
    Head head;
    bool has_format = false;
    for (;;) {
        std::string_view line = lines.want("end_header");
        const std::string_view word = take_word(line);
        if (word == "end_header") break;
        if (word == "format") {
            const std::string_view kind = take_word(line);
            if (kind != "ascii" && kind != "binary_little_endian" && kind != "binary_big_endian") lines.refuse(fmt::format("'{}' is not a format of .ply", kind));
            head.kind = kind == "ascii" ? Values::Kind::ascii : kind == "binary_big_endian" ? Values::Kind::big : Values::Kind::little;
            has_format = true;
        } else if (word == "element") {
            Element element;
            element.name = take_word(line);
            element.count = lines.take_count(line, "element NAME COUNT");
            if (element.count < 0 || element.count > static_cast<long long>(4 * most_facets)) lines.refuse(fmt::format("has {} elements; at most {} are read", element.count, 4 * most_facets));
            if (head.elements.size() == most_properties) lines.refuse(fmt::format("is element {}; at most {} are read", most_properties + 1, most_properties));
            for (const Element& before : head.elements)
                if (before.name == element.name || (before.is("vertex", "vertices") && element.is("vertex", "vertices")) || (before.is("face", "faces") && element.is("face", "faces"))) lines.refuse(fmt::format("a second element '{}'", element.name));
            head.elements.push_back(element);
        } else if (word == "property") {
            if (head.elements.empty()) lines.refuse("is a property without an element");
            Property property{};
            std::string_view type = take_word(line);
            if (type == "list") {
                property.length = type_of(take_word(line), lines);
                type = take_word(line);
            }
            property.type = type_of(type, lines);
            property.name = take_word(line);
            if (head.elements.back().properties.size() == most_properties) lines.refuse(fmt::format("is property {}; an element has at most {}", most_properties + 1, most_properties));
            for (const Property& before : head.elements.back().properties)
                if (before.name == property.name) lines.refuse(fmt::format("a second property '{}'", property.name));
            head.elements.back().properties.push_back(property);
        } else if (word != "comment" && word != "obj_info") {
            lines.refuse("is not a line of a .ply header");
        }
    }
    if (!has_format) lines.refuse("the header has no line 'format'");
    return head;
}

}  // namespace

// A reader of our own: CGAL's allocates as much memory as a damaged length demands, and misreads all values after an
// unknown type.
Facets read_ply(const std::string& file, std::string_view content) {
    TextLines lines(file, content);
    const Head head = read_head(lines);
    Values values(file, lines, head.kind);
    std::vector<MshFile::Point> points;
    std::vector<std::vector<long long>> polygons;  // kept, as points may follow them
    std::vector<long> line_of;
    bool facets_there = false;
    for (const Element& element : head.elements) {
        if (element.count > 0 && element.properties.empty()) throw FileError(fmt::format("{}: element '{}' has no properties", file, element.name));
        const bool vertex = element.is("vertex", "vertices"), face = element.is("face", "faces");
        const auto has = [&](std::string_view name, bool list) {
            return std::any_of(element.properties.begin(), element.properties.end(), [&](const Property& p) { return p.name == name && p.length.has_value() == list; });
        };
        if (vertex && !(has("x", false) && has("y", false) && has("z", false))) throw FileError(file + ": has no points with x, y and z");
        if (face && has("vertex_indices", true) == has("vertex_index", true)) throw FileError(file + ": its faces must have one list 'vertex_indices' or 'vertex_index'");
        if (face && element.count > static_cast<long long>(most_facets)) throw FileError(fmt::format("{}: has {} facets; at most {} are read", file, element.count, most_facets));
        facets_there = facets_there || face;
        for (long long n = 0; n < element.count; ++n) {
            values.begin_item();
            MshFile::Point p{};
            std::vector<long long> corners;
            for (const Property& property : element.properties) {
                const bool corner = face && property.length && (property.name == "vertex_indices" || property.name == "vertex_index");
                const double count = property.length ? values.take(*property.length) : 1;
                if (!(count >= 0 && count <= 1e6 && count == std::floor(count)) || (corner && count > most_corners)) throw FileError(fmt::format("{}: {} {} has a list '{}' of length {:g}, which is not possible", file, element.name, n + 1, property.name, count));
                for (int k = 0; k < static_cast<int>(count); ++k) {
                    const double value = values.take(property.type);
                    // Facets::add refuses -1
                    if (corner) corners.push_back(value >= 0 && value < 1e15 && value == std::floor(value) ? static_cast<long long>(value) : -1);
                    if (vertex && !property.length && property.name.size() == 1 && property.name >= "x" && property.name <= "z") (property.name == "x" ? p.x : property.name == "y" ? p.y : p.z) = value;
                }
            }
            if (vertex) points.push_back(p);
            if (!face) continue;
            polygons.push_back(std::move(corners));
            line_of.push_back(values.line());
        }
    }
    if (!facets_there) throw FileError(file + ": has points and no facets");
    Facets facets(file);
    facets.begin_group("");
    for (std::size_t f = 0; f < polygons.size(); ++f) facets.add(points, polygons[f], line_of[f]);
    return facets;
}

}  // namespace tissue::surface_file
