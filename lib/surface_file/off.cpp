#include <fmt/format.h>

#include "error.h"
#include "surface_file/facets.h"
#include "surface_file/text_lines.h"

namespace tissue::surface_file {

// A reader of our own: CGAL's allocates as much memory as a damaged count demands.
Facets read_off(const std::string& file, std::string_view content) {
    constexpr const char *head = "POINTS FACETS EDGES", *vertex = "x y z", *facet = "COUNT i j k ..";
    TextLines lines(file, without_mark(content), '#');
    std::string_view line = lines.want("OFF");
    const std::string_view kind = take_word(line);
    if (kind.size() < 3 || kind.substr(kind.size() - 3) != "OFF" || kind.find_first_not_of("STCNOF") != std::string_view::npos) lines.refuse("is not 'OFF'");
    if (trimmed(line) == "BINARY") lines.refuse("is a binary .off, which is not supported: save it as text, or as .ply");
    if (trimmed(line).empty()) line = lines.want(head);
    const long long points_said = lines.take_count(line, head), facets_said = lines.take_count(line, head);
    if (points_said < 0 || facets_said < 0) lines.refuse(fmt::format("is not '{}'", head));
    std::vector<MshFile::Point> points;
    for (long long n = 0; n < points_said; ++n) {
        line = lines.want(vertex);
        MshFile::Point p{};
        for (double* value : {&p.x, &p.y, &p.z}) *value = lines.take_number(line, vertex);
        if (kind == "OFF" && !trimmed(line).empty()) lines.refuse(fmt::format("has more than '{}'; a file with colours must begin with COFF", vertex));
        points.push_back(p);
    }
    Facets facets(file);
    facets.begin_group("");
    for (long long f = 0; f < facets_said; ++f) {
        line = lines.want(facet);
        const long long count = lines.take_count(line, facet);
        if (count < 3 || count > static_cast<long long>(most_corners)) lines.refuse(fmt::format("is a facet of {} corners; it must have 3 to {}", count, most_corners));
        std::vector<long long> corners;
        for (long long k = 0; k < count; ++k) corners.push_back(lines.take_count(line, facet));
        facets.add(points, corners, lines.number());
    }
    return facets;
}

}  // namespace tissue::surface_file
