#include <fmt/format.h>

#include <map>

#include "error.h"
#include "surface_file/facets.h"
#include "surface_file/text_lines.h"

namespace tissue::surface_file {
namespace {

constexpr const char *vertex = "v x y z", *facet = "f i j k ..";

}  // namespace

// A reader of our own: CGAL's ignores groups and refuses lines of edges; tinyobjloader reads a damaged number as zero.
Facets read_obj(const std::string& file, std::string_view content) {
    TextLines lines(file, without_mark(content));
    using Group = std::pair<std::string, std::string>;  // object and group
    std::vector<MshFile::Point> points;
    std::vector<std::vector<long long>> polygons;  // kept, as a facet may name points that follow it
    std::vector<long> line_of;
    std::vector<std::size_t> group;
    std::vector<Group> groups;  // groups with facets
    std::map<Group, std::size_t> place_of;
    Group now;
    for (std::string_view line = lines.next(); !line.empty(); line = lines.next()) {
        const std::string_view word = take_word(line);
        if (word == "v" || word == "f") line = line.substr(0, line.find('#'));  // comments; a name may have a #
        if (word == "v") {
            MshFile::Point p{};
            for (double* value : {&p.x, &p.y, &p.z}) *value = lines.take_number(line, vertex);
            points.push_back(p);
        } else if (word == "f") {
            std::vector<long long> corners;
            while (!(line = trimmed(line)).empty()) {
                std::string_view corner = take_word(line);
                corner = corner.substr(0, corner.find('/'));
                const long long number = lines.take_count(corner, facet), there = number > 0 ? number - 1 : static_cast<long long>(points.size()) + number;
                if (number == 0 || there < 0) lines.refuse(fmt::format("names point {} of {}", number, points.size()));
                corners.push_back(there);
            }
            if (corners.size() < 3) lines.refuse(fmt::format("is not '{}'", facet));
            if (polygons.size() == most_facets) lines.refuse(fmt::format("is facet {}; at most {} are read", most_facets + 1, most_facets));
            polygons.push_back(std::move(corners));
            line_of.push_back(lines.number());
            const auto [place, fresh] = place_of.emplace(now, groups.size());
            if (fresh) groups.push_back(now);
            group.push_back(place->second);
        } else if (word == "o") {
            now = {std::string(trimmed(line)), ""};
        } else if (word == "g") {
            now.second = trimmed(line);
        }
    }
    Facets facets(file);
    const auto name_of = [](const Group& g) { return g.second.empty() ? g.first : g.second; };
    std::map<std::string, int> count;
    for (const Group& g : groups) ++count[name_of(g)];
    for (const Group& g : groups) facets.begin_group(count[name_of(g)] == 1 || g.first.empty() || g.second.empty() ? name_of(g) : g.first + "/" + g.second);
    for (std::size_t f = 0; f < polygons.size(); ++f) {
        facets.go_on_with(static_cast<int>(group[f]) + 1);
        facets.add(points, polygons[f], line_of[f]);
    }
    return facets;
}

}  // namespace tissue::surface_file
