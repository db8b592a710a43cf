#pragma once

#include <vector>

#include "haptic/moving_surface.h"

namespace tissue {

/// The closed outline of a mesh in the plane, counter-clockwise.
class MovingOutline final : public MovingSurface {
   public:
    explicit MovingOutline(int segments);                ///< nodes are placed by set(); move() has no effect
    explicit MovingOutline(const SpringMesh& mesh);      ///< at rest; throws MismatchError for a solid mesh

    /// Sets the position of outline node b [m]. refresh() must follow the last one.
    void set(int b, const Eigen::Vector2d& position_m) noexcept {
        x_[static_cast<std::size_t>(b)] = position_m.x();
        y_[static_cast<std::size_t>(b)] = position_m.y();
    }
    void refresh() noexcept;
    void move(const Point& place_m, const NodeColumns& rest, const NodeColumns& u) noexcept override;
    Eigen::Vector2d node(int b) const noexcept { return {x_[static_cast<std::size_t>(b)], y_[static_cast<std::size_t>(b)]}; }
    Eigen::Vector2d at(int segment, double w) const noexcept { return (1 - w) * node(segment) + w * node(segment + 1); }
    Point at(int segment, const Eigen::Vector3d& weight) const noexcept override { return at(segment, weight[1]); }

    /// True where a ray to the right (along +x) crosses an odd number of segments.
    bool contains(const Point& p) const noexcept override;
    SurfacePlace nearest(const Point& p) const noexcept override;
    std::optional<SurfacePlace> first_crossing(const Point& p, const Point& m) const noexcept override;

    /// True when the outline is counter-clockwise (positive area), and no two segments cross or touch, except for
    /// neighbours at their common node.
    bool simple() noexcept override;

   private:
    bool crosses(int a, int b) const noexcept;

    std::vector<int> nodes_;                             ///< nodes of the mesh, in order (M)
    int count_;
    std::vector<double> x_, y_;                          ///< node positions, the first again at the end [m] (M + 1)
    std::vector<double> low_x_, high_x_, low_y_, high_y_;  ///< bounding boxes of the segments [m] (M)
};

}  // namespace tissue
