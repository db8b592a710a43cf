#pragma once

#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

/// Gives each node of an embedded lattice a row in the tick's arrays, so that springs and cubes lie in long runs. Neighbours along x are one row apart; neighbours along
/// y are equally far apart everywhere, and neighbours along z within one layer. A layer has one row for each place from its first node to its last, x first; rows
/// without a node hold 0. The solid's own nodes have no row. In any other mesh, and in a lattice that would need more than four rows a node, row i is node i.
class LatticeRows {
   public:
    /// Throws MismatchError where two nodes round to one place of the lattice and rows are not by node.
    explicit LatticeRows(const SpringMesh& mesh);

    bool by_node() const { return row_.empty(); }  ///< row i is node i
    int count() const { return count_; }
    int of(int node) const { return by_node() ? node : row_[static_cast<std::size_t>(node)]; }  ///< -1: none

    // where rows are not by node:
    /// by_row (count() x D) gets what nodes have (N x D); its other rows are left as they are. Allocates nothing.
    void scatter(const NodeColumns& by_node, NodeColumns& by_row) const noexcept;
    /// The reverse; nodes without a row get 0. Allocates nothing.
    void gather(const NodeColumns& by_row, NodeColumns& by_node) const noexcept;

   private:
    struct Run {
        int node, row, count;
    };
    std::vector<int> row_;   ///< (N), or empty
    std::vector<Run> runs_;  ///< of nodes whose rows follow one another
    int count_ = 0;
};

}  // namespace tissue
