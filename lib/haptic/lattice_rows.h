#pragma once

#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

/// Which row of the tick's arrays each node has. In an embedded lattice neighbours along x, y and z are the same number of rows apart, so that springs and cubes
/// lie in long runs: each layer of nodes takes the rows of the box about it, along x first, and rows without a node stay 0. An embedded solid's own nodes have
/// none. In any other mesh, and in a lattice that would leave three of four rows empty, row i is node i.
class LatticeRows {
   public:
    /// Throws MismatchError for an embedded lattice of which two nodes have one place.
    explicit LatticeRows(const SpringMesh& mesh);

    bool by_node() const { return row_.empty(); }  ///< row i is node i
    int count() const { return count_; }
    int of(int node) const { return by_node() ? node : row_[static_cast<std::size_t>(node)]; }  ///< -1: none

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
