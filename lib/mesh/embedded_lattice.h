#pragma once

#include "mesh/shape.h"

namespace tissue {

/// The spring mesh of a solid in an embedded lattice (mesh/embedding.h), topology "embedded". spacing_m: edge of a cube.
///
/// The lattice stands along the axes. Along each it has the solid's middle in the middle of its own, but where the held surface is a plane across an axis
/// that plane is one of the lattice's. Cubes of which more than 2 % is tissue are kept. What is in a cube is found along 6 x 6 lines parallel to z, exactly along
/// them, and kept as fractions of 6 x 6 x 6 parts.
///
/// A cut cube has the springs of a whole one, stiffer where its tissue is: of its volume V the tissue's fraction f = sum_n H_n, H_n what the trilinear hat
/// function of corner n has of it. A body diagonal counts f V, a diagonal of a face 2 V times the sum of H over the face's corners, an edge 4 V times that
/// over its two ends: f V each of a whole cube. Masses are f V / 8 at each corner, so that stiffness and mass of a cube shrink together: the fastest mode stays near that of
/// whole cubes however thin the tissue in one is (measured: 13 % above it at the most). No node has less than 0.02 of a whole one's, since supports and contacts do not shrink.
///
/// incident_measure is (7)'s: the mean over the four ways to divide a cube into six tetrahedra about one of its body diagonals, spring_share of a cube's volume from each cube that has the spring; springs
/// inside add up to 6 of a cube's volume, as six tetrahedra with six edges each do. fixed are the held nodes of the solid: the held surface is supported at points, by TissueEnergy, and the
/// lattice's nodes are all free.
/// Parts of a solid that lie within a cube of each other, a fold or two bodies, share the cube's corners and move together: the spacing has to be smaller than such gaps, which
/// nothing checks. A third of the thinnest part that is pressed is enough (findings of trials), or less.
/// Throws MismatchError for a spacing that is not positive, for no cube, more than 100,000 or 200,000 in the box about the solid, and where the lattice is so coarse that it falls apart or
/// has a node of the solid an edge or more away from every cube.
SpringMesh embedded_lattice(const Shape& shape, double spacing_m);

/// What (7) gives a spring of the volume of a cube that has it, by the number of axes that it runs along: 1/4 for an edge, 1/6 for a diagonal of a face, 1/4 for one of the body.
double spring_share(int axes);

/// The same lattice moved by a part of an edge along each axis, 0 to 1, whatever plane the held surface is.
SpringMesh shifted_lattice(const Shape& shape, double spacing_m, const Eigen::Vector3d& shift);

}  // namespace tissue
