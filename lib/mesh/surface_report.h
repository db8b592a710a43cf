#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mesh/msh_file.h"

namespace tissue {

/// A kind of fault of a surface as the boundary of a solid, with its count and first positions, in the file's unit.
struct SurfaceFault {
    enum class Kind {
        holes,       ///< connected sets of edges with one triangle only; at the mean of their points
        crowded,     ///< edges that more than two triangles share (non-manifold)
        one_sided,   ///< edges where triangles cannot be oriented alike
        pinched,     ///< points where a closed surface touches itself
        crossings,   ///< pairs of triangles that intersect; the count stops at 10,000
        parts,       ///< connected parts besides the largest; at the centres of their boxes
        handles,     ///< holes through a closed surface, as of a ring
        flat,        ///< triangles without area
    };
    Kind kind;
    std::size_t count;
    std::vector<Eigen::Vector3d> first;  ///< positions of the first three at most; none for handles
    double largest = 0;                  ///< holes: longest perimeter; parts: largest extent
};

/// Measures and faults of a surface, in the file's unit of length.
struct SurfaceReport {
    std::size_t points = 0, triangles = 0, slivers = 0;
    std::size_t turned = 0;            ///< triangles that point inwards; no fault, as filling turns them
    Eigen::Vector3d low, high;         ///< corners of the bounding box
    double area = 0, volume = 0;       ///< volume: of the largest part; 0 if the surface is not closed
    double shortest = 0, mean = 0;     ///< length of edges
    std::vector<SurfaceFault> faults;  ///< empty if the surface can be filled
};

/// A triangle with a smaller angle counts as a sliver. Slivers are no fault, because the surface is remeshed.
constexpr double sliver_angle_deg = 1;

/// Checks the triangles of a mesh. Throws FileError if it has none.
SurfaceReport report_on(const MshFile& mesh);

/// A fault as one line of text: "1 hole, perimeter 12.3 mm; at (4, 5, 6)". Positions are in the file's unit. unit:
/// appended to lengths, as " mm"; factor: number of these units in one unit of the file.
std::string fault_text(const SurfaceFault& fault, const std::string& unit, double factor);
const char* fault_name(SurfaceFault::Kind kind);  ///< key in JSON

}  // namespace tissue
