#pragma once

#include <map>
#include <string>
#include <vector>

namespace tissue {

/// A mesh as gmsh writes it: MSH 2.2, ASCII, straight lines and triangles, in space tetrahedra too. Nothing about it is
/// checked but that it is one.
struct MshFile {
    struct Point {
        double x, y, z;
    };
    struct Element {
        long number;   ///< the file's own
        int node[4];   ///< places in `points`; a line has two, a triangle three
        int physical;  ///< tag of its physical group; 0: in none
    };
    std::string file;                       ///< as messages name it
    std::vector<Point> points;              ///< in the file's unit of length
    std::vector<Element> lines, triangles, tetrahedra;  ///< an element in two groups stands twice
    std::map<int, std::string> line_names, triangle_names, tetrahedron_names;  ///< of the physical groups, by tag
};

/// solid: whether tetrahedra belong there. Throws FileError with file, line and cause: missing, another format, cut off, an
/// element that is neither a line nor a straight triangle, in space nor a straight tetrahedron (quadrilaterals, hexahedra
/// and second-order elements are named), a node that does not exist.
MshFile read_msh(const std::string& file, bool solid = false);

}  // namespace tissue
