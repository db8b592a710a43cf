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
        int node[3];   ///< places in `points`; a line has two
        int physical;  ///< tag of its physical group; 0: in none
    };
    struct Tetrahedron {
        long number;
        int node[4];
        int physical;
    };
    std::string file;                       ///< as messages name it
    std::vector<Point> points;              ///< in the file's unit of length
    std::vector<Element> lines, triangles;  ///< an element in two groups stands twice
    std::vector<Tetrahedron> tetrahedra;
    std::map<int, std::string> line_names, triangle_names, tetrahedron_names;  ///< of the physical groups, by tag; one without a name has its number
};

/// Throws FileError with file, line and cause: missing, another format, cut off, an element that is neither a line nor a
/// straight triangle (quadrilaterals, tetrahedra and second-order elements are named), a node that does not exist.
/// in_space: tetrahedra are welcome. named: what messages call the file, without lines, where it is another made of that one.
MshFile read_msh(const std::string& file, bool in_space = false, const std::string& named = "");

}  // namespace tissue
