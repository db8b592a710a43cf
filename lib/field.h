#pragma once

#include <Eigen/Core>

namespace tissue {

/// Positions [m], displacements [m] or forces [N] of nodes (N x D): one row per node, one column per axis. Row-major,
/// so that its storage is the vector of degrees of freedom, D * node + axis.
using NodeField = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A position [m], displacement [m] or force [N] (D); D = 2 in the plane, 3 in space. Allocates nothing.
using Point = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3, 1>;

/// Values of nodes (N x D) as in a NodeField, but column-major: the values of one axis are contiguous, so that a loop
/// over nodes reads memory in order. The tick stores u [m], v [m/s] and f [N] in this form.
using NodeColumns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>;

/// A linear map from one Point to another (D x D). Allocates nothing.
using PointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;

/// Node numbers, one row per spring, cell, simplex or facet.
using Cells = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The vector of degrees of freedom of a field (N*D), without a copy.
inline Eigen::Map<const Eigen::VectorXd> as_vector(const NodeField& field) {
    return {field.data(), field.size()};
}

}  // namespace tissue
