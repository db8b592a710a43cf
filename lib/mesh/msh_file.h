#pragma once

#include <map>
#include <string>
#include <vector>

namespace tissue {

/// A mesh file of gmsh: MSH 2.2, ASCII, straight lines and triangles, in space tetrahedra too. Only the format is
/// checked, not the geometry.
struct MshFile {
    struct Point {
        double x, y, z;
    };
    struct Element {
        long number;   ///< as in the file
        int node[3];   ///< indices into `points`; a line has two
        int physical;  ///< tag of its physical group; 0: none
    };
    struct Tetrahedron {
        long number;
        int node[4];
        int physical;
    };
    std::string file;                       ///< name of the file in messages
    std::vector<Point> points;              ///< in the file's unit of length
    std::vector<Element> lines, triangles;  ///< an element in two groups is listed twice
    std::vector<Tetrahedron> tetrahedra;
    /// Names of the physical groups by tag. A group without a name is called by its number.
    std::map<int, std::string> line_names, triangle_names, tetrahedron_names;
};

/// Reads a file. in_space: whether tetrahedra are allowed. named: if not empty, messages have this name instead of the
/// file's, and no line numbers; for a file that was made from the named one.
/// Throws FileError with file, line and cause: the file is missing, has another format or breaks off; an element is
/// neither a line nor a straight triangle (messages name quadrilaterals, tetrahedra and second-order elements); a node
/// does not exist or is listed twice; a coordinate is not finite or beyond 1e12; there are more than a million names,
/// nodes or elements; an unnamed group has the number that is another group's name.
MshFile read_msh(const std::string& file, bool in_space = false, const std::string& named = "");

}  // namespace tissue
