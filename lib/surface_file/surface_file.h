#pragma once

#include <string>

#include "mesh/msh_file.h"

namespace tissue {

/// Endings of files that are a surface of facets in space, which is filled, as messages list them.
constexpr const char* surface_endings = ".stl, .obj, .ply, .off, .glb";

/// Whether a file's name ends in one of surface_endings, in capitals or not.
bool is_surface_file(const std::string& file);

/// The facets of such a file as triangles; facets of more corners are divided. Corners nearer to each other than 1e-8 of the extent's diagonal are
/// one point, the first of them, as gmsh has it; a facet with less than three points left is dropped.
/// Where several groups of a file have facets and one of them a name, every group is one here, numbered from 1 in the file's order; one without a name is
/// called by its number. Else all facets are in group 0. Groups are, of
///   .stl  the solids of an ASCII file. A name is all that follows `solid`, without blanks and line ends about it; keywords may be in capitals. What stands
///         behind the facets of a binary file does not count.
///   .obj  what follows the same `o` and `g`, called by its `g`, or its `o` where it has none, or OBJECT/GROUP where several objects have a group of that name
///   .glb  the nodes with a mesh, moved as their scene says (z stays z: the standard has y upwards), which are called by their own name or their mesh's. A file's unit is the metre, by its standard.
///   .ply, .off  none
/// Throws FileError with file, line or facet, and cause: missing, of another kind, cut off, a coordinate that is no finite number, a corner that does
/// not exist, no facets, more than a million.
MshFile read_surface_file(const std::string& file);

/// The surface of a file by its ending, MSH 2.2 too; read_msh's arguments.
MshFile read_surface_or_msh(const std::string& file, const std::string& named);

/// The same under its own name: HeldRegion's reader. Throws FileError for what is no regular file, such as a pipe, which would not end.
MshFile read_other_surface(const std::string& file);

}  // namespace tissue
