#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

#include "error.h"
#include "surface_file/facets.h"
#include "surface_file/text_lines.h"

namespace tissue::surface_file {
namespace {

constexpr std::size_t binary_head = 84, binary_facet = 50;

class AsciiReader {
   public:
    AsciiReader(const std::string& file, std::string_view text) : file_(file), lines_(file, text), facets_(file) {}

    Facets read() {
        bool open = false;
        for (std::string_view line = lines_.next(); !line.empty(); line = lines_.next()) {
            const std::string_view word = take_word(line);
            if (is_word(word, "solid")) {
                if (open) lines_.refuse("a solid begins before 'endsolid' of the solid before it");
                facets_.begin_group(std::string(trimmed(line)));
                open = true;
            } else if (is_word(word, "endsolid")) {
                if (!open) lines_.refuse("'endsolid' without 'solid'");
                open = false;
            } else if (is_word(word, "facet") && open) {
                facet();
            } else {
                lines_.refuse(open ? "is neither 'facet' nor 'endsolid'" : "is not 'solid'");
            }
        }
        if (open) throw FileError(file_ + ": is truncated: 'endsolid' is missing");
        return std::move(facets_);
    }

   private:
    void facet() {
        want("outer", "outer loop");
        std::array<MshFile::Point, 3> corners;
        for (MshFile::Point& p : corners) {
            std::string_view line = want("vertex", "vertex x y z");
            for (double* value : {&p.x, &p.y, &p.z}) *value = lines_.take_number(line, "vertex x y z");
            if (!trimmed(line).empty()) lines_.refuse("is not 'vertex x y z'");
        }
        want("endloop", "endloop");
        want("endfacet", "endfacet");
        facets_.add(corners);
    }

    /// Reads the next line, which must begin with `word`. Result: the rest of the line. whole: the line's form, for
    /// messages.
    std::string_view want(std::string_view word, const char* whole) {
        std::string_view line = lines_.want(whole);
        if (!is_word(take_word(line), word)) lines_.refuse(fmt::format("is not '{}'", whole));
        return line;
    }

    const std::string& file_;
    TextLines lines_;
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
    if (bytes.size() < binary_head) throw FileError(file + ": is not an .stl: it neither begins with 'solid' nor has the header of 84 bytes of a binary .stl");
    const std::uint32_t count = little_endian(&bytes[binary_head - 4]);
    if (count > most_facets && bytes.size() > binary_head + binary_facet * most_facets)
        throw FileError(fmt::format("{}: has {} facets; at most {} are read", file, count, most_facets));
    // more bytes are allowed, as some programs append data; the first bytes of a text make a far too large count
    if (binary_head + binary_facet * count > bytes.size())
        throw FileError(fmt::format("{}: is truncated, or not an .stl: the header of a binary .stl states {} facets, which need {} bytes; the file has {}", file, count,
                                    binary_head + binary_facet * std::size_t{count}, bytes.size()));
    Facets facets(file);
    facets.begin_group("");
    for (std::size_t f = 0; f < count; ++f) {
        const char* corner = &bytes[binary_head + binary_facet * f] + 12;  // after the normal
        std::array<MshFile::Point, 3> corners;
        for (MshFile::Point& p : corners) {
            p = {little_endian_float(corner), little_endian_float(corner + 4), little_endian_float(corner + 8)};
            corner += 12;
        }
        facets.add(corners);
    }
    return facets;
}

/// Whether a text that begins with `solid` is ASCII. A binary file's head may begin with that word too: a text with
/// zero bytes must therefore have `facet` or `endsolid` on its second line.
bool is_ascii(std::string_view text) {
    const bool no_zero = text.find('\0') == std::string_view::npos;
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\v\f\n"), text.size()));
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view first = text.substr(0, end), rest = text.substr(std::min(end + 1, text.size()));
    if (!is_word(take_word(first), "solid") || first.find('\0') != std::string_view::npos) return false;
    if (no_zero) return true;
    const std::size_t next = rest.find_first_not_of(" \t\r\v\f\n");
    if (next == std::string_view::npos) return true;
    std::string_view line = rest.substr(next, 20);
    line = line.substr(0, line.find('\n'));
    const std::string_view word = take_word(line);
    return is_word(word, "facet") || is_word(word, "endsolid");
}

}  // namespace

Facets read_stl(const std::string& file, std::string_view content) {
    const std::string_view text = without_mark(content);
    return is_ascii(text) ? AsciiReader(file, text).read() : read_binary(file, content);
}

}  // namespace tissue::surface_file
