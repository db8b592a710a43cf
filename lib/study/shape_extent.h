#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mesh/surface_report.h"

namespace tissue {

/// What a shape's file shows to a reader that does not mesh it: how large it is, and which of its parts have names.
struct ShapeExtent {
    bool solid = false;                                ///< in space
    std::vector<std::string> boundaries;               ///< named curves; in space surfaces
    std::vector<std::string> regions;                  ///< named surfaces; in space volumes
    std::optional<std::array<double, 3>> low, high;    ///< box of its points, in the file's unit; none where gmsh alone knows it
    std::optional<SurfaceFault> fault;                 ///< the first that keeps a surface from being filled
    std::size_t nodes = 0;                             ///< of a mesh, whose elements in the plane are the springs' own; 0 of any other file
};

/// Reads .msh (2.2 and 4.1, ASCII), .geo and surfaces (surface_file/surface_file.h). A .geo is read, never run: its points are known where all of them stand there as
/// numbers. Throws FileError with file and cause.
ShapeExtent shape_extent(const std::string& file);

}  // namespace tissue
