#include "mesh/msh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <unordered_map>

#include "error.h"
#include "io/atomic_file.h"

namespace tissue {
namespace {

/// gmsh's type numbers of elements other than lines and straight triangles.
const std::map<int, std::string> other_kinds = {
    {3, "a quadrilateral"},    {4, "a tetrahedron"},          {5, "a hexahedron"},           {6, "a prism"},
    {7, "a pyramid"},          {8, "a second-order line"},    {9, "a second-order triangle"}, {10, "a quadrilateral"},
    {11, "a tetrahedron"},     {12, "a hexahedron"},          {13, "a prism"},               {14, "a pyramid"},
    {16, "a quadrilateral"},   {17, "a hexahedron"},          {18, "a prism"},               {19, "a pyramid"}};

/// In the file's unit of length. With larger coordinates areas and volumes may overflow.
constexpr double largest_coordinate = 1e12;

/// Most names, nodes or elements. No solver here can use more, and a damaged count must not allocate memory.
constexpr long largest_count = 1'000'000;

class Lines {
   public:
    Lines(const std::string& file, const std::string& named) : file_(named.empty() ? file : named), own_(named.empty()), in_(read_file(file)) {}

    std::string next(const char* wanted) {
        std::string line;
        if (!std::getline(in_, line)) throw FileError(fmt::format("{}: is truncated: {} is missing", file_, wanted));
        ++number_;
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        return line;
    }

    bool more() { return in_.peek() != std::istringstream::traits_type::eof(); }

    long count(const char* wanted) {
        std::istringstream words(next(wanted));
        long n = 0;
        if (!(words >> n) || n < 0) refuse(fmt::format("is not {}", wanted));
        if (n > largest_count) refuse(fmt::format("{} is {}; at most {} are read", wanted, n, largest_count));
        return n;
    }

    void want(const std::string& line) {
        if (next(line.c_str()) != line) refuse("is not " + line);
    }

    [[noreturn]] void refuse(const std::string& why) const {
        throw FileError(own_ ? fmt::format("{}:{}: {}", file_, number_, why) : fmt::format("{}: {}", file_, why));
    }

   private:
    std::string file_;
    bool own_;  ///< whether line numbers are of the file that messages name
    std::istringstream in_;
    long number_ = 0;
};

template <typename Elements>
void name_by_number(const std::string& file, const Elements& elements, std::map<int, std::string>& names) {
    for (const auto& e : elements) {
        if (e.physical == 0 || names.count(e.physical) > 0) continue;
        const std::string number = std::to_string(e.physical);
        if (std::any_of(names.begin(), names.end(), [&](const auto& named) { return named.second == number; }))
            throw FileError(fmt::format("{0}: its group {1} has no name, and another group has the name '{1}': give every group a name", file, number));
        names.emplace(e.physical, number);
    }
}

}  // namespace

MshFile read_msh(const std::string& file, bool in_space, const std::string& named) {
    Lines in(file, named);
    MshFile mesh;
    mesh.file = named.empty() ? file : named;
    std::unordered_map<long, int> place;  // the file's node number -> index into points
    bool elements = false;
    if (in.next("$MeshFormat") != "$MeshFormat") in.refuse("is not a gmsh mesh: it does not begin with $MeshFormat");
    const std::string format = in.next("the format");
    if (format.rfind("2.", 0) != 0) in.refuse("has MSH format '" + format + "', not 2.2; gmsh -save -format msh22 converts it");
    if (format.size() < 5 || format.substr(3, 2) == " 1" || format.find(" 0 ") == std::string::npos)
        in.refuse("is a binary mesh; gmsh -save -format msh22 makes it text");
    in.want("$EndMeshFormat");
    while (in.more()) {
        const std::string section = in.next("a section");
        if (section.empty()) continue;
        if (section == "$PhysicalNames") {
            for (long n = in.count("the number of names"); n > 0; --n) {
                std::istringstream words(in.next("a physical name"));
                int dimension = 0, tag = 0;
                std::string name;
                if (!(words >> dimension >> tag) || !std::getline(words >> std::ws, name) || name.size() < 2)
                    in.refuse("is not a physical name");
                name = name.substr(1, name.size() - 2);
                if (dimension == 1) mesh.line_names[tag] = name;
                if (dimension == 2) mesh.triangle_names[tag] = name;
                if (dimension == 3) mesh.tetrahedron_names[tag] = name;
            }
            in.want("$EndPhysicalNames");
        } else if (section == "$Nodes") {
            for (long n = in.count("the number of nodes"); n > 0; --n) {
                std::istringstream words(in.next("a node"));
                long number = 0;
                std::string x, y, z;
                if (!(words >> number >> x >> y >> z)) in.refuse("is not a node");
                MshFile::Point p{};
                try {
                    p = {std::stod(x), std::stod(y), std::stod(z)};
                } catch (const std::exception&) {
                    p.x = std::nan("");
                }
                if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                    in.refuse(fmt::format("node {} has a coordinate that is not a finite number", number));
                if (const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); largest > largest_coordinate)
                    in.refuse(fmt::format("node {} has a coordinate of {:g}; at most {:g} is allowed", number, largest, largest_coordinate));
                if (!place.emplace(number, static_cast<int>(mesh.points.size())).second)
                    in.refuse(fmt::format("node {} is present twice", number));
                mesh.points.push_back(p);
            }
            in.want("$EndNodes");
        } else if (section == "$Elements") {
            for (long n = in.count("the number of elements"); n > 0; --n) {
                std::istringstream words(in.next("an element"));
                long number = 0;
                int kind = 0, tags = 0;
                if (!(words >> number >> kind >> tags)) in.refuse("is not an element");
                if (kind == 15) continue;  // a point
                if (kind != 1 && kind != 2 && !(kind == 4 && in_space)) {
                    const auto known = other_kinds.find(kind);
                    in.refuse(fmt::format("element {} is {}; a tissue needs straight {}", number,
                                          known == other_kinds.end() ? fmt::format("of gmsh type {}", kind)
                                                                     : known->second,
                                          in_space ? "tetrahedra" : "triangles, in the plane"));
                }
                MshFile::Tetrahedron e{number, {0, 0, 0, 0}, 0};
                for (int t = 0; t < tags; ++t) {
                    long tag = 0;
                    if (!(words >> tag)) in.refuse("is not an element");
                    if (t == 0) e.physical = static_cast<int>(tag);
                    if (t == 0 && e.physical != tag) in.refuse(fmt::format("element {} has a physical group {} out of range", number, tag));
                }
                for (int i = 0; i < (kind == 4 ? 4 : kind + 1); ++i) {
                    long node = 0;
                    if (!(words >> node)) in.refuse("is not an element");
                    const auto there = place.find(node);
                    if (there == place.end()) in.refuse(fmt::format("element {} names node {}, which does not exist", number, node));
                    e.node[i] = there->second;
                }
                if (kind == 4) mesh.tetrahedra.push_back(e);
                else (kind == 1 ? mesh.lines : mesh.triangles).push_back({number, {e.node[0], e.node[1], e.node[2]}, e.physical});
            }
            in.want("$EndElements");
            elements = true;
        } else {  // other sections of gmsh are skipped
            if (section.front() != '$') in.refuse("is not the beginning of a section");
            const std::string end = "$End" + section.substr(1);
            while (in.next(end.c_str()) != end) {}
        }
    }
    if (!elements) throw FileError(mesh.file + ": is truncated: it has no $Elements");
    name_by_number(mesh.file, mesh.lines, mesh.line_names);
    name_by_number(mesh.file, mesh.triangles, mesh.triangle_names);
    name_by_number(mesh.file, mesh.tetrahedra, mesh.tetrahedron_names);
    return mesh;
}

}  // namespace tissue
