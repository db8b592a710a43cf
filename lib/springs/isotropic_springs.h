#pragma once

#include <Eigen/Core>
#include <optional>

#include "mesh/spring_mesh.h"

namespace tissue {

/// Shares of a cell's measure for its springs that make the cell elastically isotropic.
///
/// Parallel springs of measure w per volume store w E (n e n)^2 / 2 under a strain e, with their direction n. The sum
/// over directions is isotropic if the sums of w n_a^4 are 3 c for each axis, and those of w n_a^2 n_b^2 are c for each
/// pair of axes. In the plane this determines all shares. In space the body diagonals remain free. The shares of
/// Lebedev's rule of 26 points are used (weights per direction 40 : 32 : 27; Lebedev 1976, USSR Computational
/// Mathematics and Mathematical Physics 16(2): 10-24). Its sums equal those over all directions to the seventh order.
/// Nonlinear springs (springs/spring_curve.h) are therefore isotropic to the next order too. The total measure is that
/// of the paper's (7): 4 cell measures in the plane, 6 in space.
struct RectangleShares {
    double along_x, along_y, diagonal;  ///< of a square: 1/2, 1/2 and 1
};
/// sides_m: sides of a cell in the plane [m]. Empty if the ratio of the sides is sqrt(3) or more: an edge's share would
/// not be positive.
std::optional<RectangleShares> isotropic_shares(const Eigen::Vector2d& sides_m);
/// for a cube's 12 edges, 12 face diagonals and 4 body diagonals
constexpr double cube_edge_share = 1 / 7.0, cube_face_share = 8 / 35.0, cube_body_share = 27 / 70.0;

/// SpringMesh::incident_measure (S) with isotropic shares in place of those of (7), for lattices with diagonals whose
/// cells have such shares. Unchanged for other meshes.
Eigen::VectorXd isotropic_measure(const SpringMesh& mesh);

}  // namespace tissue
