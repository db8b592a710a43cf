#pragma once

#include <Eigen/Core>

#include "mesh/msh_file.h"

namespace tissue {

/// How a surface is made anew, in its file's unit of length.
struct SurfaceRepair {
    double closes;  ///< holes, gaps and cavities narrower than this are closed
    double offset;  ///< how far outside of the given triangles the new ones lie
};

/// How far the new surface lies from the given one, in the file's unit.
struct RepairDistances {
    double median, most;           ///< from all over the new surface to the given triangles
    double given_median, given_most;  ///< from all over the given triangles to the new ones
    Eigen::Vector3d given_at;      ///< where that is most: what was inside, or was left out
    std::size_t left_out;          ///< parts of the new surface beside the largest
};

/// A closed surface without crossings about a mesh's triangles, however damaged they are: CGAL's alpha wrap, its largest part, with the numbers of an .stl. Groups are
/// lost.
/// Throws MismatchError for lengths that are not positive or finer than a 250th of the extent (closes) and a 100,000th of it (offset).
struct RepairedSurface {
    MshFile mesh;
    RepairDistances distances;
};
RepairedSurface repaired(const MshFile& mesh, const SurfaceRepair& repair);

/// A fiftieth of a mesh's longest extent to close, a thousandth as offset.
SurfaceRepair usual_repair(const MshFile& mesh);

/// As a binary .stl, whose numbers are floats.
std::string to_stl(const MshFile& mesh);

}  // namespace tissue
