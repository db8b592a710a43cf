#pragma once

#include <Eigen/Core>
#include <optional>

#include "mesh/spring_mesh.h"

namespace tissue {

/// What part of a cell's measure belongs to each of its springs, so that all together are as stiff one way as another.
///
/// Parallel springs of measure w per volume store w E (n e n)^2 / 2 under a strain e, n their direction. The sum over directions is isotropic where the sums of w n_a^4 are
/// 3 c for each axis and those of w n_a^2 n_b^2 are c for each pair of axes. In the plane that decides everything. In space it leaves the body diagonals free; taken are the shares
/// of Lebedev's rule of 26 points (weights per direction 40 : 32 : 27; Lebedev 1976, USSR Computational Mathematics and Mathematical Physics 16(2): 10-24), whose sums are those of all directions to
/// the seventh order, so that springs that are not linear (springs/spring_curve.h) are isotropic to the next order too. The sum is that of the paper's (7): 4 in the plane, 6 in space.
struct RectangleShares {
    double along_x, along_y, diagonal;  ///< of a square 1/2, 1/2 and 1
};
/// sides_m: of a cell in the plane. Nothing for cells so oblong that an edge would have to be negative: sides that differ by sqrt(3) or more.
std::optional<RectangleShares> isotropic_shares(const Eigen::Vector2d& sides_m);
constexpr double cube_edge_share = 1 / 7.0, cube_face_share = 8 / 35.0, cube_body_share = 27 / 70.0;  ///< of a cube's 12, 12 and 4

/// SpringMesh::incident_measure with these shares in place of (7)'s, on a lattice with diagonals whose cells have them; elsewhere as it is (S).
Eigen::VectorXd isotropic_measure(const SpringMesh& mesh);

}  // namespace tissue
