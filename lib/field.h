#pragma once

#include <Eigen/Core>

namespace tissue {

/// One row a node, one column a space dimension (N x D): positions, displacements [m] or forces [N]. Row-major, so
/// that its storage is the vector of degrees of freedom, D * node + axis.
using NodeField = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A place, a displacement or a force (D), D = 2 in the plane and 3 in space. Allocates nothing.
using Point = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3, 1>;

/// The same as a NodeField, one axis after the other in memory, so that a loop over nodes reads in a row: the tick's u [m], v [m/s]
/// and f [N] (N x D).
using NodeColumns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>;

/// What turns one Point into another (D x D). Allocates nothing.
using PointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;

/// Node numbers, one row a piece: springs, cells, simplices, facets.
using Cells = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A field as its vector of degrees of freedom (N*D).
inline Eigen::Map<const Eigen::VectorXd> as_vector(const NodeField& field) {
    return {field.data(), field.size()};
}

}  // namespace tissue
