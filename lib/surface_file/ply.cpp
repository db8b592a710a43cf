#include <CGAL/IO/PLY.h>
#include <CGAL/Simple_cartesian.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <sstream>
#include <streambuf>

#include "error.h"
#include "surface_file/facets.h"
#include "surface_file/text_lines.h"

namespace tissue::surface_file {
namespace {

/// What CGAL's reader would take otherwise without a word: lists that may be as long as their four bytes say, whose memory it takes, and
/// coordinates of another type, which it leaves as they are. Returns how many points the head says.
void check_head(const std::string& file, std::string_view content) {
    TextLines lines(file, content);
    if (lines.want("ply") != "ply") lines.refuse("is no .ply: it does not begin with 'ply'");
    std::set<std::string> coordinates;
    bool of_points = false, facets = false;
    for (;;) {
        std::string_view line = lines.want("end_header");
        const std::string_view word = take_word(line);
        if (word == "end_header") break;
        if (word == "element") {
            const std::string_view name = take_word(line);
            of_points = name == "vertex" || name == "vertices";
            facets = facets || name == "face" || name == "faces";
            const long long count = lines.take_count(line, "element NAME COUNT");
            if (count < 0 || count > static_cast<long long>(content.size())) lines.refuse(fmt::format("says {} elements, in a file of {} bytes", count, content.size()));
        } else if (word == "property") {
            const std::string_view type = take_word(line);
            if (type == "list") {
                const std::string_view size = take_word(line);
                if (size != "uchar" && size != "uint8" && size != "char" && size != "int8")
                    lines.refuse(fmt::format("has lists whose length is a {}; lengths of a uchar are read", size));
            } else if (of_points) {
                const std::string_view name = take_word(line);
                if (name == "x" || name == "y" || name == "z") {
                    if (type != "float" && type != "float32" && type != "double" && type != "float64") lines.refuse(fmt::format("a coordinate is a {}; float and double are read", type));
                    coordinates.emplace(name);
                }
            }
        }
    }
    if (coordinates.size() != 3) throw FileError(file + ": has no points with x, y and z");
    if (!facets) throw FileError(file + ": has points and no facets");
}

/// A text where it stands.
class Bytes : public std::streambuf {
   public:
    explicit Bytes(std::string_view text) {
        char* begin = const_cast<char*>(text.data());  // read only
        setg(begin, begin, begin + text.size());
    }
    std::size_t taken() const { return static_cast<std::size_t>(gptr() - eback()); }
};

}  // namespace

Facets read_ply(const std::string& file, std::string_view content) {
    using Point = CGAL::Simple_cartesian<double>::Point_3;
    check_head(file, content);
    Bytes bytes(content);
    std::istream in(&bytes);
    std::vector<Point> places;
    std::vector<std::vector<long long>> polygons;
    if (!CGAL::IO::read_PLY(in, places, polygons))
        throw FileError(fmt::format("{}: is cut off, or damaged: reading stopped at byte {} of {}, after {} points and {} facets", file, bytes.taken(), content.size(), places.size(), polygons.size()));
    std::vector<MshFile::Point> points;
    for (const Point& p : places) points.push_back({p.x(), p.y(), p.z()});
    Facets facets(file);
    facets.begin_group("");
    for (const auto& corners : polygons) facets.add(points, corners);
    return facets;
}

}  // namespace tissue::surface_file
