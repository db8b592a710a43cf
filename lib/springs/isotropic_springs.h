#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "mesh/spring_mesh.h"

namespace tissue {

/// What part of a cell's measure belongs to each of its springs, so that all together are as stiff one way as another: by the axes along which the spring runs (1 along x, 2 along y, 4
/// along z, summed). cell_m: sides of a cell (D).
///
/// Parallel springs of measure w per volume store w E (n e n)^2 / 2 under a strain e, n their direction. The sum over directions is isotropic where the sums of w n_a^4 are
/// 3 c for each axis and those of w n_a^2 n_b^2 are c for each pair of axes. In the plane that decides everything. In space it leaves the body diagonals free, from none, or from where
/// the edges of some axis vanish, to where the face diagonals of some plane do; the middle is taken, so that no family is missing. Cubes then have 0.15 of a cell for an edge, 0.20 for a diagonal of a face, 0.45 for one of
/// the body, squares 1/2 and 1. The sum is that of the paper's (7): 4 in the plane, 6 in space.
/// Nothing for cells so oblong that an edge would have to be negative: sides that differ by sqrt(3) or more, in space by about that.
std::optional<std::array<double, 8>> isotropic_shares(const Point& cell_m);

/// SpringMesh::incident_measure with these shares in place of (7)'s, on a lattice with diagonals whose cells have them; elsewhere as it is (S).
Eigen::VectorXd isotropic_measure(const SpringMesh& mesh);

}  // namespace tissue
