#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mesh/msh_file.h"

namespace tissue {

/// What is wrong with a surface's triangles as the boundary of a solid: how often, and where first. Places are in the file's unit.
struct SurfaceFault {
    enum class Kind {
        holes,      ///< closed ways along sides that one triangle alone has; each at its middle
        crowded,    ///< sides that more than two triangles have
        turned,     ///< sides that both triangles run in the same direction
        crossings,  ///< pairs of triangles that cut each other
        parts,      ///< connected parts beside the largest; each at its middle
        handles,    ///< holes through a closed part
        flat,       ///< triangles without area
    };
    Kind kind;
    std::size_t count;
    std::vector<Eigen::Vector3d> first;  ///< of at most three; of handles none
    double largest = 0;                  ///< of holes the longest way round; of parts the largest extent
};

struct SurfaceReport {
    std::size_t points = 0, triangles = 0, slivers = 0;
    Eigen::Vector3d low, high;
    double area = 0, volume = 0;       ///< volume: 0 where it does not close
    double shortest = 0, mean = 0;     ///< sides
    std::vector<SurfaceFault> faults;  ///< none of a surface that can be filled
};

constexpr double sliver_angle_deg = 1;  ///< a triangle with a smaller angle counts as a sliver; it is no fault, as the surface is divided anew

/// Throws FileError where the mesh has no triangles.
SurfaceReport report_on(const MshFile& mesh);

/// In one line for people: "3 holes, the longest of 12.3 round (4, 5, 6)". unit: a word behind lengths, as " mm"; factor: what makes lengths of the file's.
std::string fault_text(const SurfaceFault& fault, const std::string& unit, double factor);
const char* fault_name(SurfaceFault::Kind kind);  ///< as JSON calls it

}  // namespace tissue
