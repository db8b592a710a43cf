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

    /// The place at weights of a free facet's nodes (a segment's third is 0), its distance 0. Allocates nothing.
    Place place(Eigen::Index facet, const Eigen::Vector3d& weight) const noexcept;

    /// Free facet of each facet of the mesh (SpringMesh::facets), -1 where it is held.
    const std::vector<Eigen::Index>& free_of() const { return free_of_; }
    Eigen::Index facet_of(Eigen::Index free) const noexcept { return facet_of_[static_cast<std::size_t>(free)]; }  ///< facet of the mesh of a free one

    /// Where a way along the surface ends.
    struct Walk {
        int facet;               ///< of the mesh (SpringMesh::facets)
        Eigen::Vector3d weight;  ///< of its nodes (a segment's third is 0)
        Point along_m;           ///< the way as it points there, in the facet's plane; as long as at its beginning
        double walked_m;         ///< shorter than the way where it ended at the border
        bool at_border;
    };
    /// Goes along the surface at rest, from a place on a facet of the mesh, by a vector: the part of it in that facet's plane. Over an
    /// edge the way goes straight on as if the next facet were unfolded into the plane of the one before. It stops at the border of
    /// the free surface; on a held facet it does not move. Allocates nothing.
    Walk walk(int facet, const Eigen::Vector3d& weight, const Point& along_m) const noexcept;

    /// From a point to the nearest node where the surface ends or turns by more than 45 degrees [m].
    double to_crease_m(const Point& position_m) const noexcept;

    /// In space, from a point to the nearest edge where the free surface ends, or turns by more than 45 degrees [m]; infinite where
    /// it does neither.
    double clearance_m(const Point& position_m) const;

    /// In space, how far the tissue reaches from a point of its surface along a direction into it [m]: to where that leaves the tissue, through a free or a held
    /// facet; infinite where it meets none.
    double thickness_m(const Point& position_m, const Point& inward) const;

    /// In space: the middles of parts of the free facets, parts^2 of each, all alike.
    std::vector<Point> points(int parts) const;

    const Eigen::VectorXd& measure() const { return measure_; }  ///< length or area of each free facet
    Point at(Eigen::Index facet, const Eigen::Vector3d& weight) const;  ///< by weights of a facet's nodes (a segment's third is 0)

    /// Whether the surface at a node faces the way a normal does, to 60 degrees: it lies round no crease from there.
    bool faces(int node, const Point& inward) const noexcept;

   private:
    Point node_inward(int node, const Point& facet_inward) const;
    void join_facets();

    NodeField rest_;
    Cells facets_, held_facets_;
    std::vector<int> nodes_, creases_;
    Cells ends_;                                     ///< in space: edges where it ends or turns, as segments
    std::vector<std::vector<Eigen::Index>> around_;  ///< free facets of each node (N)
    std::vector<Point> inward_;                      ///< of each free facet
    std::vector<Point> corner_inward_;               ///< at each node of each free facet, without what lies round a crease
    std::vector<Point> facing_;                      ///< inward at each node, whatever lies around it (N)
    std::vector<Eigen::Index> free_of_, facet_of_;   ///< free facet of each of the mesh, and the other way round
    std::vector<Eigen::Index> beside_;               ///< over each end or edge of each free facet, from its node k on: the free facet, or -1
    Eigen::VectorXd measure_;                        ///< of each free facet
    double spacing_m_;
};

/// Nodes whose displacement counts as the tissue's shape: in the plane all, in space those of the free surface.
std::vector<int> seen_nodes(const SpringMesh& mesh);

}  // namespace tissue
