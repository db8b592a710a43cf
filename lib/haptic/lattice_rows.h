#pragma once

#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

/// Row numbers of the nodes of an embedded lattice in the tick's arrays, such that springs and cubes form long runs.
///
/// Neighbours along x are one row apart. Neighbours along y are equally many rows apart everywhere, and neighbours
/// along z are equally many rows apart within a layer. A layer has one row for each lattice place from its first node
/// to its last, x first; rows without a node hold 0. The embedded solid's own nodes have no row.
///
/// In any other mesh, and in a lattice that would need more than four rows a node, row i is node i.
class LatticeRows {
   public:
    /// Throws MismatchError where two nodes round to one place of the lattice and rows are not by node.
    explicit LatticeRows(const SpringMesh& mesh);

    bool by_node() const { return row_.empty(); }  ///< row i is node i
    int count() const { return count_; }           ///< number of rows
    /// Row of a node; -1 where it has none.
    int of(int node) const { return by_node() ? node : row_[static_cast<std::size_t>(node)]; }

    // where rows are not by node:
    /// Copies values by node (N x D) to by_row (count() x D). Rows without a node stay unchanged. Allocates nothing.
    void scatter(const NodeColumns& by_node, NodeColumns& by_row) const noexcept;
    /// Copies values by row back to nodes. Nodes without a row get 0. Allocates nothing.
    void gather(const NodeColumns& by_row, NodeColumns& by_node) const noexcept;

   private:
    struct Run {
        int node, row, count;
    };
    std::vector<int> row_;   ///< row of each node (N); empty: rows are by node
    std::vector<Run> runs_;  ///< runs of nodes with consecutive rows
    int count_ = 0;
};

}  // namespace tissue
