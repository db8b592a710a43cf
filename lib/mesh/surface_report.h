#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mesh/msh_file.h"

namespace tissue {

/// What is wrong with a surface's triangles as the boundary of a solid: how often, and where first. Places are in the file's unit.
struct SurfaceFault {
    enum class Kind {
        holes,       ///< what is connected of edges that one triangle alone has; each at its middle
        crowded,     ///< edges that more than two triangles share
        one_sided,   ///< edges where the triangles cannot be turned to agree on what is outside
        pinched,     ///< points where a closed surface touches itself
        crossings,   ///< pairs of triangles that cut each other; counted to 10,000
        parts,       ///< connected parts beside the largest; each at its middle
        handles,     ///< holes through a closed part, as of a ring
        flat,        ///< triangles without area
    };
    Kind kind;
    std::size_t count;
    std::vector<Eigen::Vector3d> first;  ///< of at most three; of handles none
    double largest = 0;                  ///< of holes the longest perimeter; of parts the largest extent
};

struct SurfaceReport {
    std::size_t points = 0, triangles = 0, slivers = 0;
    std::size_t turned = 0;            ///< triangles that point inwards; no fault, as they are turned when the surface is filled
    Eigen::Vector3d low, high;
    double area = 0, volume = 0;       ///< volume: of the largest part; 0 where it does not close
    double shortest = 0, mean = 0;     ///< edges
    std::vector<SurfaceFault> faults;  ///< none of a surface that can be filled
};

constexpr double sliver_angle_deg = 1;  ///< a triangle with a smaller angle counts as a sliver; it is no fault, as the surface is divided anew

/// Throws FileError where the mesh has no triangles.
SurfaceReport report_on(const MshFile& mesh);

/// In one line for people: "1 hole, perimeter 12.3 mm; at (4, 5, 6)", places in the file's unit. unit: a word behind lengths, as " mm"; factor: its number in one of the file's.
std::string fault_text(const SurfaceFault& fault, const std::string& unit, double factor);
const char* fault_name(SurfaceFault::Kind kind);  ///< as JSON calls it

}  // namespace tissue
