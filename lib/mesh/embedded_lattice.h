#pragma once

#include "mesh/shape.h"

namespace tissue {

/// Spring mesh of a solid in an embedded lattice (mesh/embedding.h), topology "embedded".
/// shape: the solid [m]; spacing_m: edge of a cube [m].
///
/// Position: the lattice is parallel to the axes and centred on the solid's bounding box. Where the fixed surface is a
/// plane across an axis, that plane is a lattice plane instead.
/// Cubes: a cube is kept if more than 2 % of its volume is tissue. The tissue is integrated along 6 x 6 lines a cube,
/// parallel to z and exact along each line. It is stored as fractions of 6 x 6 x 6 parts.
///
/// Springs: a cut cube has the springs of a whole cube, stiffer where its tissue is. Let V be the volume of a cube and
/// f its tissue fraction. Then f = sum_n H_n, where H_n is the integral of corner n's trilinear hat function over the
/// tissue, divided by V. The springs' volumes are
///   f V for a body diagonal,
///   2 V times the sum of H over the face's corners for a face diagonal,
///   4 V times the sum of H over the two ends for an edge.
/// In a whole cube all three are equal to f V.
/// Masses: each corner gets f V / 8. Stiffness and mass of a cube thus decrease together. The fastest mode stays near
/// that of whole cubes, however little tissue a cube has (measured: at most 13 % above). At a lattice node
/// node_measure is at least 0.02 V, because supports and contacts do not become softer with f.
///
/// incident_measure is that of (7), as the mean over the four divisions of a cube into six tetrahedra around one body
/// diagonal. A spring gets spring_share of its volume above from each cube that has the spring. The springs of a whole
/// cube sum to 6 V, as the edges of six tetrahedra with six edges each do.
/// fixed: the fixed nodes of the solid. TissueEnergy supports the fixed surface at these points; all lattice nodes are
/// free.
///
/// Limits: parts of a solid less than a cube apart (a fold, two bodies) share the cube's corners and move together. The
/// spacing must therefore be smaller than such gaps; nothing checks this. In trials a third of the thinnest part under
/// the tool, or less, was small enough.
/// Throws MismatchError if the spacing is not positive; there are no cubes, or more than 100,000; the bounding box has
/// room for more than 200,000; the cubes are not connected; a node of the solid is an edge or more from every cube.
SpringMesh embedded_lattice(const Shape& shape, double spacing_m);

/// Share of a whole cube's volume that (7) gives a spring. axes: number of axes that the spring runs along. 1/4 for an
/// edge (1), 1/6 for a face diagonal (2), 1/4 for a body diagonal (3).
double spring_share(int axes);

/// The same lattice, moved along each axis by a part of a cube edge (0 to 1). A shift above 0 also moves it off a fixed
/// plane.
SpringMesh shifted_lattice(const Shape& shape, double spacing_m, const Eigen::Vector3d& shift);

}  // namespace tissue
