#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mesh/surface_report.h"

namespace tissue {

/// Size and named parts of a shape, read from its file without meshing it.
struct ShapeExtent {
    bool solid = false;                                ///< whether it is three-dimensional
    std::vector<std::string> boundaries;               ///< named curves; in space surfaces
    std::vector<std::string> regions;                  ///< named surfaces; in space volumes
    /// Corners of the bounding box of its points, in the file's unit; none where only gmsh can compute it.
    std::optional<std::array<double, 3>> low, high;
    std::optional<SurfaceFault> fault;                 ///< first fault because of which a surface cannot be filled
    std::size_t nodes = 0;                             ///< number of nodes of a .msh; 0 for any other file
};

/// Reads .msh (2.2 and 4.1, ASCII), .geo and surfaces (surface_file/surface_file.h). A .geo is parsed, never run. Its
/// box is known only where all points are given by numbers and no command moves, copies or includes geometry.
/// Throws FileError with file and cause.
ShapeExtent shape_extent(const std::string& file);

}  // namespace tissue
