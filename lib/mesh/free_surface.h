#pragma once

#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

/// The free surface of a spring mesh at rest, in the plane or in space: the boundary's facets with at least one node
/// that is not fixed. For the plane mesh/outline.h has it as one line with arc length.
class FreeSurface {
   public:
    explicit FreeSurface(const SpringMesh& mesh);

    const Cells& facets() const { return facets_; }            ///< at least one node of each is free
    const Cells& fixed_facets_of_surface() const { return fixed_facets_of_surface_; }  ///< all their nodes are fixed
    const std::vector<int>& nodes() const { return nodes_; }   ///< nodes of the free facets, ascending
    /// Mean spacing of these nodes: mean length of a segment; in space sqrt(2 mean area of a facet). On a lattice it is
    /// the edge of a cell.
    double spacing_m() const { return spacing_m_; }

    /// A point of the free surface.
    struct Place {
        Eigen::Index facet;      ///< number of the free facet
        Point point_m, inward;   ///< inward: unit normal into the tissue, continuous except at creases
        double distance_m;       ///< from the position that nearest() got
    };
    /// The point of the free surface nearest to a position [m] (D).
    Place nearest(const Point& position_m) const;

    /// The point at given weights of a free facet's nodes; the third weight of a segment is 0. distance_m is 0.
    /// Allocates nothing.
    Place place(Eigen::Index facet, const Eigen::Vector3d& weight) const noexcept;

    /// Number of the free facet of each facet of the mesh (SpringMesh::facets); -1 if it is fixed.
    const std::vector<Eigen::Index>& free_of() const { return free_of_; }
    /// Facet of the mesh (SpringMesh::facets) of a free facet.
    Eigen::Index facet_of(Eigen::Index free) const noexcept { return facet_of_[static_cast<std::size_t>(free)]; }

    /// End of a path along the surface.
    struct Walk {
        int facet;               ///< of the mesh (SpringMesh::facets)
        Eigen::Vector3d weight;  ///< of the facet's nodes; the third weight of a segment is 0
        Point along_m;           ///< direction of the path at its end, in the facet's plane; as long as the whole path
        double walked_m;         ///< length of the path; less than the whole if it stopped early
        bool at_border;
    };
    /// Follows the surface at rest from a point of a facet of the mesh, by the part of the vector along_m [m] (D) in
    /// that facet's plane. Across an edge the path is straight as if the next facet were unfolded into the plane of the
    /// one before. It stops at the border of the free surface, and after 1000 facets. It does not leave a fixed facet.
    /// Allocates nothing.
    Walk walk(int facet, const Eigen::Vector3d& weight, const Point& along_m) const noexcept;

    /// Distance [m] to the nearest node where the free surface ends or turns by more than 45 degrees; infinite if there
    /// is none.
    double to_crease_m(const Point& position_m) const noexcept;

    /// In space: distance [m] to the nearest edge where the free surface ends or turns by more than 45 degrees;
    /// infinite if there is none.
    double clearance_m(const Point& position_m) const;

    /// In space: thickness of the tissue [m] from a point of its surface along a unit vector into it. It ends where the
    /// ray leaves the tissue through a free or a fixed facet; infinite if the ray leaves through none.
    double thickness_m(const Point& position_m, const Point& inward) const;

    /// In space: centroids of parts^2 equal triangles of each free facet [m].
    std::vector<Point> points(int parts) const;

    const Eigen::VectorXd& measure() const { return measure_; }  ///< length [m] or area [m^2] of each free facet
    /// Position [m] at given weights of a free facet's nodes; the third weight of a segment is 0.
    Point at(Eigen::Index facet, const Eigen::Vector3d& weight) const;

    /// Whether the surface normal at a node is within 60 degrees of a given inward normal. If not, a crease lies
    /// between them.
    bool faces(int node, const Point& inward) const noexcept;

   private:
    Point node_inward(int node, const Point& facet_inward) const;
    void join_facets();

    NodeField rest_;
    Cells facets_, fixed_facets_of_surface_;
    std::vector<int> nodes_, creases_;
    Cells ends_;                                     ///< in space: edges where the surface ends or turns, as segments
    std::vector<std::vector<Eigen::Index>> around_;  ///< free facets of each node (N)
    std::vector<Point> inward_;                      ///< normal of each free facet
    std::vector<Point> corner_inward_;               ///< normal at each facet's nodes, without facets across a crease
    std::vector<Point> facing_;                      ///< mean normal at each node, with facets across creases (N)
    std::vector<Eigen::Index> free_of_, facet_of_;   ///< free facet of each facet of the mesh, and the reverse
    std::vector<Eigen::Index> beside_;               ///< free facet across end k, or edge k to k + 1; -1: none
    Eigen::VectorXd measure_;                        ///< of each free facet
    double spacing_m_;
};

/// Nodes of the indentation error of displacement: all nodes in the plane, those of the free surface in space.
std::vector<int> compared_nodes(const SpringMesh& mesh);

}  // namespace tissue
