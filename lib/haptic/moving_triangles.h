#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "haptic/moving_surface.h"

namespace tissue {

/// The closed triangulated boundary of a mesh in space, normals out. Over it stands a tree of boxes, divided at rest; move() fits
/// the boxes to where the triangles are, since which triangles there are does not change.
///
/// contains() counts what a ray along the first axis crosses, first_crossing() looks along the way itself. Both decide for each edge
/// alone, and for both its triangles alike, on which side of the line it passes: along a line no crossing is lost or doubled at an
/// edge or a node, whatever is rounded.
///
/// simple() finds in every call a surface turned inside out, as its volume is not positive. For crossings it looks at a part of the
/// triangles in each call, and at all pairs within ticks_to_look() calls: a crossing that stays is found within as many calls of
/// having begun, and one found counts until its triangle is looked at again, as many calls later at the most. A surface that crosses itself at rest is known as such from the beginning.
/// Looking at all in each tick would take as long as many ticks have. A crossing that is not found yet costs no more than Safety lets through
/// (MovingSurface::simple).
/// Two triangles with a common edge cross when one lies folded back on the other, to 1e-4 rad.
class MovingTriangles final : public MovingSurface {
   public:
    explicit MovingTriangles(const SpringMesh& mesh);  ///< At rest. Throws MismatchError in the plane, or where it is not closed.

    int triangles() const { return static_cast<int>(corners_.size()); }
    int ticks_to_look() const { return (triangles() + looked_at_ - 1) / looked_at_; }

    void move(const Point& place_m, const NodeColumns& rest, const NodeColumns& u) noexcept override;
    Point at(int facet, const Eigen::Vector3d& weight) const noexcept override;
    bool contains(const Point& p) const noexcept override;
    SurfacePlace nearest(const Point& p) const noexcept override;
    std::optional<SurfacePlace> first_crossing(const Point& p, const Point& m) const noexcept override;
    bool simple() noexcept override;
    void fields(StateBytes& state) noexcept override { state(crossed_, crossings_, next_); }

   private:
    using Corners = std::array<int, 3>;
    struct Box {
        double low[4], high[4];  ///< the fourth of no meaning
    };
    struct Line;
    struct Crossing {
        double along;
        Eigen::Vector3d weight;
    };

    const double* node(int n) const { return &x_[4 * static_cast<std::size_t>(n)]; }
    Eigen::Vector3d place(int n) const { return Eigen::Map<const Eigen::Vector3d>(node(n)); }
    int first_of(std::size_t leaf) const { return static_cast<int>(leaf * corners_.size() / leaves_); }
    void divide(std::vector<int>& order, const std::vector<Eigen::Vector3d>& middles, std::size_t leaf, std::size_t leaves);
    void refit() noexcept;
    bool crossed_by(const Line& line, int triangle, Crossing& crossing) const noexcept;
    struct Plane;
    bool meet(const Plane& a, int b) const noexcept;
    bool meets_a_later_one(int triangle) const noexcept;
    void look_at(int triangle) noexcept;

    // triangles in the order of the tree's leaves
    std::vector<Corners> corners_;              ///< node numbers here
    std::vector<int> corner_[3];                ///< the same, one after the other
    std::vector<int> facet_, triangle_of_;      ///< facet of the mesh of each triangle, and the other way round
    std::vector<int> nodes_;                    ///< of the mesh
    std::vector<double> x_;                     ///< places, four numbers each: the last of them is 0
    std::size_t leaves_ = 1;                    ///< a power of two
    std::vector<Box> boxes_;                    ///< children of i are 2 i and 2 i + 1, the root is 1
    std::vector<int> leaf_begin_, leaf_nodes_;  ///< each leaf's nodes, none twice
    std::vector<char> crossed_;                 ///< whether each triangle met a later one, when it was looked at last
    int crossings_ = 0;                         ///< how many of them
    int looked_at_ = 0, next_ = 0;
};

}  // namespace tissue
