#pragma once

#include <string>

#include "mesh/msh_file.h"

namespace tissue {

/// Whether a file's name ends in .stl, in capitals or not.
bool is_stl(const std::string& file);

/// The facets of an .stl, ASCII or binary, as triangles. Corners nearer to each other than 1e-8 of the extent's diagonal are one point,
/// the first of them, as gmsh has it; a facet with less than three points left is dropped.
/// Where an ASCII file has several solids and one of them a name, every solid is a group, numbered from 1 in the file's order;
/// one without a name is called by its number. Else all facets are in group 0. A name is all that follows `solid`, without blanks and
/// line ends about it; keywords may be in capitals. What stands behind the facets of a binary file does not count.
/// Throws FileError with file, line or facet, and cause: missing, neither kind, cut off, a coordinate that is no finite number,
/// no facets, more than a million.
MshFile read_stl(const std::string& file);

/// The surface of a file by its ending, .stl or MSH 2.2; read_msh's arguments.
MshFile read_surface_file(const std::string& file, const std::string& named);

}  // namespace tissue
