#include "study/shape_extent.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <regex>
#include <set>
#include <sstream>
#include <utility>

#include "error.h"
#include "io/atomic_file.h"
#include "surface_file/surface_file.h"
#include "surface_file/vtk_file.h"

namespace tissue {
namespace {

void include(ShapeExtent& shape, const std::array<double, 3>& point, const std::string& file) {
    for (double x : point)
        if (!std::isfinite(x)) throw FileError(file + ": a coordinate is not a finite number");
    if (!shape.low) shape.low = shape.high = point;
    for (std::size_t i = 0; i < 3; ++i) {
        (*shape.low)[i] = std::min((*shape.low)[i], point[i]);
        (*shape.high)[i] = std::max((*shape.high)[i], point[i]);
    }
}

void add_name(std::vector<std::string>& names, const std::string& name) {
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

bool has_depth(const ShapeExtent& shape) {
    return shape.low && (*shape.high)[2] - (*shape.low)[2] > 1e-9 * ((*shape.high)[0] - (*shape.low)[0]);
}

// ---- .msh

/// Reads a number. Throws FileError where the section ends or contains something else.
template <class Number>
Number next(std::istringstream& in, const std::string& file, const char* section) {
    Number value{};
    if (!(in >> value)) throw FileError(fmt::format("{}: cannot read ${}: a number is missing", file, section));
    return value;
}

std::istringstream section_of(const std::string& text, const std::string& file, const std::string& name) {
    const std::size_t at = text.find("$" + name + "\n"), carriage = text.find("$" + name + "\r\n");
    const std::size_t begin = std::min(at, carriage), end = text.find("$End" + name, begin == std::string::npos ? 0 : begin);
    if (begin == std::string::npos || end == std::string::npos) throw FileError(fmt::format("{}: has no complete ${} section", file, name));
    const std::size_t line = text.find('\n', begin) + 1;
    return std::istringstream(text.substr(line, end - line));
}

void read_points(const std::string& text, const std::string& file, bool blocks, ShapeExtent& shape) {
    std::istringstream in = section_of(text, file, "Nodes");
    const auto number = [&] { return next<double>(in, file, "Nodes"); };
    const auto count = [&] { return next<long>(in, file, "Nodes"); };
    const auto point = [&] {
        const double x = number(), y = number();
        include(shape, {x, y, number()}, file);
        ++shape.nodes;
    };
    if (!blocks) {
        for (long left = count(); left > 0; --left) count(), point();
        return;
    }
    const long entities = count();
    for (int i = 0; i < 3; ++i) count();
    for (long e = 0; e < entities; ++e) {
        const long dimension = count();
        count();
        // number of coordinates of a node on its curve, surface or volume, which follow x, y and z
        const long parameters = count() != 0 ? dimension : 0;
        const long here = count();
        for (long i = 0; i < here; ++i) count();
        for (long i = 0; i < here; ++i) {
            point();
            for (long k = 0; k < parameters; ++k) number();
        }
    }
}

/// Whether the file has tetrahedra. Throws FileError for elements of second order.
bool has_tetrahedra(const std::string& text, const std::string& file, bool blocks) {
    std::istringstream in = section_of(text, file, "Elements");
    std::string line;
    std::getline(in, line);
    long skip = 0;
    while (std::getline(in, line)) {
        if (blocks && skip-- > 0) continue;
        std::istringstream words(line);
        const auto number = [&] { return next<long>(words, file, "Elements"); };
        if (blocks) number(), number();
        else number();
        const long kind = number();
        if (kind == 9 || kind == 11) throw FileError(file + ": has elements of second order; save it with first order: gmsh -order 1");
        if (kind == 4) return true;
        if (blocks) skip = number();
    }
    return false;
}

/// Numbers of the physical groups of curves (dimension 1), surfaces (2) or volumes (3).
std::set<int> physical_groups(const std::string& text, const std::string& file, bool blocks, int dimension) {
    std::set<int> groups;
    if (blocks) {  // MSH 4.1 lists them with the entities
        if (text.find("$Entities") == std::string::npos) return groups;
        std::istringstream in = section_of(text, file, "Entities");
        const auto number = [&] { return next<double>(in, file, "Entities"); };
        const auto count = [&] { return next<long>(in, file, "Entities"); };
        long of[4];
        for (long& n : of) n = count();
        for (int d = 0; d < 4; ++d)
            for (long e = 0; e < of[d]; ++e) {
                count();
                for (int k = 0; k < (d == 0 ? 3 : 6); ++k) number();
                for (long left = count(); left > 0; --left)
                    if (const long group = std::abs(count()); d == dimension) groups.insert(static_cast<int>(group));
                for (long left = d == 0 ? 0 : count(); left > 0; --left) count();
            }
        return groups;
    }
    std::istringstream in = section_of(text, file, "Elements");
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
        std::istringstream words(line);
        long number = 0, kind = 0, tags = 0, group = 0;
        if (!(words >> number >> kind >> tags >> group) || tags < 1 || group <= 0) continue;
        const int of = kind == 1 || kind == 8 ? 1 : kind == 2 || kind == 9 ? 2 : kind == 4 || kind == 11 ? 3 : 0;
        if (of == dimension) groups.insert(static_cast<int>(group));
    }
    return groups;
}

ShapeExtent msh_extent(const std::string& text, const std::string& file) {
    std::istringstream format = section_of(text, file, "MeshFormat");
    const double version = next<double>(format, file, "MeshFormat");
    if (next<int>(format, file, "MeshFormat") != 0)
        throw FileError(fmt::format("{0}: is binary; save it as text: gmsh -save -format msh22 {0} -o NEW.msh", file));
    if (version != 2.2 && version != 4.1) throw FileError(fmt::format("{}: has MSH format {:g}; formats 2.2 and 4.1 are read", file, version));
    const bool blocks = version > 3;
    ShapeExtent shape;
    read_points(text, file, blocks, shape);
    shape.solid = has_tetrahedra(text, file, blocks);
    if (!shape.solid && has_depth(shape))
        throw FileError(file + ": has triangles in space and no tetrahedra; save its surface as .stl, which is then filled");
    const int boundary = shape.solid ? 2 : 1;
    std::set<int> curves = physical_groups(text, file, blocks, boundary), regions = physical_groups(text, file, blocks, boundary + 1);
    if (text.find("$PhysicalNames") != std::string::npos) {
        static const std::regex row("\\s*([0-3])\\s+(\\d{1,9})\\s+\"([^\"]*)\"\\s*");
        std::istringstream in = section_of(text, file, "PhysicalNames");
        std::smatch match;
        for (std::string line; std::getline(in, line);) {
            if (line.size() > 1000 || !std::regex_match(line, match, row)) continue;
            const int dimension = std::stoi(match[1]);
            if (dimension == boundary) add_name(shape.boundaries, match[3]), curves.erase(std::stoi(match[2]));
            if (dimension == boundary + 1) add_name(shape.regions, match[3]), regions.erase(std::stoi(match[2]));
        }
    }
    // a group without a name is called by its number
    const auto by_number = [&file](std::vector<std::string>& names, const std::set<int>& groups) {
        for (const int group : groups) {
            if (std::find(names.begin(), names.end(), std::to_string(group)) != names.end())
                throw FileError(fmt::format("{0}: its group {1} has no name, and another group has the name '{1}': give every group a name", file, group));
            names.push_back(std::to_string(group));
        }
    };
    by_number(shape.boundaries, curves);
    by_number(shape.regions, regions);
    return shape;
}

// ---- surfaces

ShapeExtent surface_extent(const std::string& file) {
    const MshFile mesh = read_surface_file(file);
    ShapeExtent shape;
    shape.solid = true;
    for (const MshFile::Point& p : mesh.points) include(shape, {p.x, p.y, p.z}, file);
    if (const SurfaceReport report = report_on(mesh); !report.faults.empty()) shape.fault = report.faults.front();
    for (const auto& [solid, name] : mesh.triangle_names) add_name(shape.boundaries, name);
    return shape;
}

// ---- .geo

/// Infinity where the number is too large for a double; `include` refuses it.
double real_of(const std::string& digits) { return std::strtod(digits.c_str(), nullptr); }

std::string without_blanks(std::string text) {
    text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c == ' ' || c == '\t'; }), text.end());
    return text;
}

/// Matches line by line and skips very long lines, because std::regex matches by recursion. Successive parts of a
/// pattern have no characters in common, so that the time of a line is not quadratic in its length.
ShapeExtent geo_extent(const std::string& text, const std::string& file) {
    constexpr std::size_t longest_line = 2000;
    const std::string real = "\\s*([-+]?(?:[0-9]+(?:\\.[0-9]*)?|\\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\\s*";
    const std::regex any("\\bPoint\\s*\\("), volume("\\bVolume\\b");
    const std::regex middle("\\b(?:Circle|Ellipse)\\s*\\([^()]*\\)\\s*=\\s*\\{[^,{}]*,\\s*([0-9]+)\\s*,");
    const std::regex numbers("\\bPoint\\s*\\(([^()]*)\\)\\s*=\\s*\\{" + real + "," + real + "," + real + "[,}]");
    const std::regex elsewhere("OpenCASCADE|/\\*|\\b(Include|Merge|Macro|Translate|Rotate|Dilate|Symmetry|Extrude)\\b");
    const std::regex group("\\bPhysical\\s+(Curve|Line|Surface|Volume)\\s*\\(\\s*(?:\"([^\"]*)\"|([0-9]+))");
    using Matches = std::sregex_iterator;
    ShapeExtent shape;
    bool all_known = true, volumes = false;
    std::vector<std::pair<int, std::string>> groups;
    std::vector<std::pair<std::string, std::array<double, 3>>> points_of;  // by number
    std::set<std::string> middles;  // centres of arcs, which may be far away from the shape
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        line.erase(std::min(line.find("//"), line.size()));
        if (line.size() > longest_line) {
            all_known = false;
            continue;
        }
        std::ptrdiff_t points = 0;
        for (Matches m(line.begin(), line.end(), numbers), end; m != end; ++m, ++points)
            points_of.emplace_back(without_blanks((*m)[1]), std::array<double, 3>{real_of((*m)[2]), real_of((*m)[3]), real_of((*m)[4])});
        for (Matches m(line.begin(), line.end(), middle), end; m != end; ++m) middles.insert((*m)[1]);
        if (points != std::distance(Matches(line.begin(), line.end(), any), Matches()) || std::regex_search(line, elsewhere)) all_known = false;
        if (std::regex_search(line, volume)) volumes = true;
        for (Matches m(line.begin(), line.end(), group), end; m != end; ++m) {
            const std::string kind = (*m)[1];
            groups.emplace_back(kind == "Volume" ? 3 : kind == "Surface" ? 2 : 1, (*m)[2].matched ? (*m)[2] : (*m)[3]);
        }
    }
    for (const auto& [number, point] : points_of)
        if (middles.count(number) == 0) include(shape, point, file);
    shape.solid = volumes || has_depth(shape);
    if (!all_known) shape.low = shape.high = std::nullopt;
    for (const auto& [dimension, name] : groups) {
        if (dimension == (shape.solid ? 2 : 1)) add_name(shape.boundaries, name);
        if (dimension == (shape.solid ? 3 : 2)) add_name(shape.regions, name);
    }
    return shape;
}

}  // namespace

ShapeExtent shape_extent(const std::string& file) {
    refuse_vtk(file);
    if (is_surface_file(file)) return surface_extent(file);
    const std::string text = read_file(file);
    const std::string ending = file.substr(std::min(file.rfind('.'), file.size()));
    if (ending == ".msh") return msh_extent(text, file);
    if (ending == ".geo") return geo_extent(text, file);
    throw FileError(fmt::format("{}: a shape must be a .geo, .msh, {}", file, surface_endings));
}

}  // namespace tissue
