#pragma once

#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

/// The free surface of a spring mesh at rest, whatever its dimension: the boundary's facets that are not held. In the plane
/// mesh/outline.h goes along it.
class FreeSurface {
   public:
    explicit FreeSurface(const SpringMesh& mesh);

    const Cells& facets() const { return facets_; }            ///< a node of them at least is free
    const Cells& held_facets() const { return held_facets_; }  ///< all their nodes are held
    const std::vector<int>& nodes() const { return nodes_; }   ///< of the free facets, ascending
    double spacing_m() const { return spacing_m_; }            ///< mean, of those nodes: a lattice's is its cells'

    /// The point of the surface nearest to a position.
    struct Place {
        Eigen::Index facet;
        Point point_m, inward;   ///< inward: unit normal into the tissue, smooth but at creases
        double distance_m;       ///< from the position
    };
    Place nearest(const Point& position_m) const;

    /// From a point to the nearest node where the surface ends or turns by more than 45 degrees [m].
    double to_crease_m(const Point& position_m) const;

    /// In space, from a point to the nearest edge where the free surface ends, or turns by more than 45 degrees [m]; infinite where
    /// it does neither.
    double clearance_m(const Point& position_m) const;

    /// In space: the middles of parts of the free facets, parts^2 of each, all alike.
    std::vector<Point> points(int parts) const;

    const Eigen::VectorXd& measure() const { return measure_; }  ///< length or area of each free facet
    Point at(Eigen::Index facet, const Eigen::Vector3d& weight) const;  ///< by weights of a facet's nodes (a segment's third is 0)

    /// Whether the surface at a node faces the way a normal does, to 60 degrees: it lies round no crease from there.
    bool faces(int node, const Point& inward) const;

   private:
    Point node_inward(int node, const Point& facet_inward) const;

    NodeField rest_;
    Cells facets_, held_facets_;
    std::vector<int> nodes_, creases_;
    Cells ends_;                                     ///< in space: edges where it ends or turns, as segments
    std::vector<std::vector<Eigen::Index>> around_;  ///< free facets of each node (N)
    std::vector<Point> inward_;                      ///< of each free facet
    Eigen::VectorXd measure_;                        ///< of each free facet
    double spacing_m_;
};

/// Nodes whose displacement counts as the tissue's shape: in the plane all, in space those of the free surface.
std::vector<int> seen_nodes(const SpringMesh& mesh);

}  // namespace tissue
