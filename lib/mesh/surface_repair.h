#pragma once

#include <Eigen/Core>

#include "mesh/msh_file.h"

namespace tissue {

/// Lengths of a repair, in the file's unit.
struct SurfaceRepair {
    double closes;  ///< holes, gaps and cavities narrower than this are closed
    double offset;  ///< distance of the new triangles outside the given ones
};

/// Distances between the new and the given surface, in the file's unit. Medians are by area.
struct RepairDistances {
    double median, most;              ///< from points of the new surface to the given triangles
    double given_median, given_most;  ///< from points of the given triangles to the new surface
    Eigen::Vector3d given_at;         ///< where given_most is: a triangle inside the solid, or one left out
    std::size_t left_out;             ///< number of parts of the new surface that were dropped; the largest is kept
};

/// A repaired surface: closed and without crossings. Its coordinates are rounded to float, as in an .stl file. It has
/// no groups.
struct RepairedSurface {
    MshFile mesh;
    RepairDistances distances;
};
/// Wraps a mesh's triangles, whatever faults they have: the largest part of CGAL's alpha wrap.
/// Throws MismatchError if repair.closes is less than 1/250 of the extent or repair.offset less than 1/100,000 of it.
/// Throws FileError if no triangle has an area, also after rounding to float.
RepairedSurface repaired(const MshFile& mesh, const SurfaceRepair& repair);

/// The default: `closes` is 1/50 of the mesh's longest extent, `offset` 1/1000.
SurfaceRepair usual_repair(const MshFile& mesh);

/// The mesh as a binary .stl, with coordinates as floats.
std::string to_stl(const MshFile& mesh);

}  // namespace tissue
