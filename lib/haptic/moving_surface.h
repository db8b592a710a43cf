#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "haptic/state_bytes.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// A point of a mesh's boundary, on one of its facets (SpringMesh::facets): x = sum_k weight_k x_k over the nodes of
/// the facet, (16)-(17) of the paper. In the plane facet b is the segment that begins at the outline's node b, and the
/// third weight is 0.
struct SurfacePlace {
    int facet = 0;
    Eigen::Vector3d weight{1, 0, 0};  ///< not negative, with sum 1
    Point position_m;                 ///< (D)
    double distance_m = 0;            ///< from the point of the query: p of nearest(), m of first_crossing()
};

/// The closed surface of one deformed mesh in this tick. The storage is allocated once: no function allocates or
/// throws. Positions must be finite. In the plane it is a MovingOutline, in space it is made of MovingTriangles.
class MovingSurface {
   public:
    virtual ~MovingSurface() = default;

    /// Moves every node of the surface to place + rest + u. place_m: origin of the mesh [m] (D). rest, u: position at
    /// rest and displacement of all nodes of the mesh [m] (N x D).
    virtual void move(const Point& place_m, const NodeColumns& rest, const NodeColumns& u) noexcept = 0;

    /// Position at weights of a facet's nodes [m] (D).
    virtual Point at(int facet, const Eigen::Vector3d& weight) const noexcept = 0;

    /// Whether a point is inside. For points on the surface the result may be either.
    virtual bool contains(const Point& p) const noexcept = 0;

    /// The point of the surface nearest to p: argmin_i ||p - n(s_i)||.
    virtual SurfacePlace nearest(const Point& p) const noexcept = 0;

    /// The crossing of the path from p to m with the surface, the one farthest from m: argmax_i ||m - int_i||. Empty
    /// when there is none.
    virtual std::optional<SurfacePlace> first_crossing(const Point& p, const Point& m) const noexcept = 0;

    /// Whether the surface is not inverted and does not intersect or touch itself. Only then "inside" is defined.
    ///
    /// In the plane every call checks the whole surface. In space the check is spread over calls: an inverted surface
    /// is found at once, a self-intersection within MovingTriangles::ticks_to_look() calls, at most 256. Until then
    /// inside and contact may be wrong. Safety still limits the force, since it does not depend on the surface: by
    /// force_max, slew, and E <= r B where `passivity` is on.
    virtual bool simple() noexcept = 0;

    /// State besides the positions of the nodes.
    virtual void fields(StateBytes&) noexcept {}

    /// Whether p is inside and farther than tolerance_m from the surface.
    bool contains_strictly(const Point& p, double tolerance_m) const noexcept { return contains(p) && nearest(p).distance_m > tolerance_m; }
};

/// The surface of a mesh at rest, with the origin of the mesh. Throws MismatchError where the surface of a
/// solid mesh is empty or not closed.
std::unique_ptr<MovingSurface> make_moving_surface(const SpringMesh& mesh);

}  // namespace tissue
