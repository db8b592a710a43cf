#pragma once

#include <string>

#include "mesh/msh_file.h"

namespace tissue {

/// Endings of surface files, as messages list them. A surface file has facets in space; the volume inside is filled.
constexpr const char* surface_endings = ".stl, .obj, .ply, .off, .glb";

/// Whether a file's name ends in one of surface_endings, in any case.
bool is_surface_file(const std::string& file);

/// Reads a surface file as triangles. Facets with more corners are divided. Corners that differ by at most 1e-8 of the
/// bounding box's diagonal along each axis become one point, the first of them, as in gmsh. A facet with less than
/// three different points is dropped.
/// Groups: if several groups of the file have facets and at least one of these has a name, they become physical groups,
/// numbered from 1 in the file's order. A group without a name is called by its number. Otherwise all facets are in
/// group 0.
///   .stl  Groups are the solids of an ASCII file. The name is the text after `solid`, trimmed. Keywords may be in any
///         case. Data after the facets of a binary file are ignored.
///   .obj  A group has the facets of one `o` and `g`. Its name is that of its `g`, or of its `o` if there is none, or
///         OBJECT/GROUP if several objects have a group of that name.
///   .glb  Groups are the nodes with a mesh, placed as in the scene; their name is the node's or else the mesh's. Axes
///         are not exchanged (the standard has y up). The unit is the metre, by the standard.
///   .ply, .off  No groups.
/// Throws FileError with file, line or facet, and cause: the file is missing, of another kind or breaks off; a
/// coordinate is not finite or beyond 1e12; a corner does not exist; there are no facets or more than a million.
MshFile read_surface_file(const std::string& file);

/// Reads a surface file, or else a file in MSH 2.2 with tetrahedra allowed. named: as for read_msh, for MSH 2.2 only.
MshFile read_surface_or_msh(const std::string& file, const std::string& named);

/// As read_surface_or_msh, with the file's own name in messages: a FixedRegion::Reader. Throws FileError also for a file
/// that is not regular, such as a pipe, because reading might not end.
MshFile read_other_surface(const std::string& file);

}  // namespace tissue
