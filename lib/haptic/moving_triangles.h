#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "haptic/moving_surface.h"

namespace tissue {

/// The closed triangulated boundary of a mesh in space, with normals outwards, in a tree of bounding boxes. The tree is
/// built at rest. move() refits its boxes to the positions of the triangles; the triangles themselves do not change.
///
/// contains() counts the triangles that a ray along the first axis crosses. first_crossing() follows the path itself.
/// Both functions decide for each edge on which side of the line it passes, with the same result for the two triangles
/// of the edge. So rounding neither loses nor doubles a crossing at an edge or a node.
///
/// simple() checks in every call for an inverted surface, whose volume is not positive. For self-intersections it
/// checks a part of the triangles in each call, and all pairs within ticks_to_look() calls. A lasting intersection is
/// found within that many calls. One that was found counts until its triangle is checked again, at most that many calls
/// later. The constructor checks all pairs at rest. Checking all pairs in one tick would take as long as many ticks.
/// Until an intersection is found, only the limits of Safety bound the force on the hand (MovingSurface::simple).
/// Two triangles with a common edge intersect when one is folded back on the other, to 1e-4 rad.
class MovingTriangles final : public MovingSurface {
   public:
    /// At rest. Throws MismatchError for a mesh in the plane, and for a surface that is empty or not closed.
    explicit MovingTriangles(const SpringMesh& mesh);

    int triangles() const { return static_cast<int>(corners_.size()); }
    /// Calls of simple() that check all pairs of triangles once.
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
        double low[4], high[4];  ///< the fourth element is padding
    };
    struct Line;
    struct Crossing {
        double along;            ///< position on the line, along its main axis [m]
        Eigen::Vector3d weight;  ///< of the triangle's corners
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
    std::vector<Corners> corners_;              ///< corners of each triangle, as indices into nodes_
    std::vector<int> corner_[3];                ///< the same, one array a corner
    std::vector<int> facet_, triangle_of_;      ///< facet of each triangle, and triangle of each facet
    std::vector<int> nodes_;                    ///< node of the mesh of each node of the surface
    std::vector<double> x_;                     ///< positions of these [m], four numbers each, the last of which is 0
    std::size_t leaves_ = 1;                    ///< number of leaves, a power of two
    std::vector<Box> boxes_;                    ///< children of i are 2 i and 2 i + 1, the root is 1
    std::vector<int> leaf_begin_, leaf_nodes_;  ///< distinct nodes of each leaf
    std::vector<char> crossed_;                 ///< whether each triangle met a later one at its last check
    int crossings_ = 0;                         ///< number of these
    int looked_at_ = 0, next_ = 0;              ///< triangles checked in a call, and the next one to be checked
};

}  // namespace tissue
