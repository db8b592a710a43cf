#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "haptic/state_bytes.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// A point of a mesh's boundary: on one of its facets (SpringMesh::facets), x = sum_k weight_k x_k, (16)-(17) of the paper with
/// as many nodes as a facet has. In the plane segment b begins at the outline's node b, and the third weight is 0.
struct SurfacePlace {
    int facet = 0;
    Eigen::Vector3d weight{1, 0, 0};  ///< none negative, sum 1
    Point position_m;                 ///< (D)
    double distance_m = 0;            ///< from whatever was asked about
};

/// The closed surface of one mesh as it stands in this tick. Storage is made once; nothing here allocates or throws. Positions must
/// be finite. In the plane haptic/moving_outline.h, in space haptic/moving_triangles.h.
class MovingSurface {
   public:
    virtual ~MovingSurface() = default;

    /// Puts every node of it at place + rest + u: rest, u of all nodes of the mesh (N x D).
    virtual void move(const Point& place_m, const NodeColumns& rest, const NodeColumns& u) noexcept = 0;

    virtual Point at(int facet, const Eigen::Vector3d& weight) const noexcept = 0;

    /// Whether a point is inside; points on the surface may be taken for either.
    virtual bool contains(const Point& p) const noexcept = 0;

    /// The point of the surface nearest to p: argmin_i ||p - n(s_i)||.
    virtual SurfacePlace nearest(const Point& p) const noexcept = 0;

    /// Where the way from p to m crosses the surface, farthest from m: argmax_i ||m - int_i||. Nothing when it does not.
    virtual std::optional<SurfacePlace> first_crossing(const Point& p, const Point& m) const noexcept = 0;

    /// Whether the surface neither crosses nor touches itself: only then is there an inside. In the plane of the surface as it is now. In space the
    /// check is spread over calls: a surface turned inside out is found at once, one that crosses itself within MovingTriangles::ticks_to_look() calls,
    /// 256 at the most. Until then inside and contact are guesses, and what bounds the hand is Safety alone, which asks nothing of the surface:
    /// force_max, slew, and E <= r B where `passivity` is on.
    virtual bool simple() noexcept = 0;

    /// What it knows beside where its nodes are.
    virtual void fields(StateBytes&) noexcept {}

    /// Inside, and farther than tolerance_m from the surface.
    bool contains_strictly(const Point& p, double tolerance_m) const noexcept { return contains(p) && nearest(p).distance_m > tolerance_m; }
};

/// At rest, its origin at the mesh's own.
std::unique_ptr<MovingSurface> make_moving_surface(const SpringMesh& mesh);

}  // namespace tissue
