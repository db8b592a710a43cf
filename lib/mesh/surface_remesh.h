#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "mesh/nearest_triangle.h"
#include "mesh/surface.h"

namespace tissue {

/// Wanted length of a side [m]: near_m within radius_m of centre_m, from there growing linearly to far_m over
/// thickness_m(), as gmsh's field Ball does.
struct SideLength {
    Eigen::Vector3d centre_m;
    double radius_m, near_m, far_m;

    double at(const Eigen::Vector3d& position_m) const;
    double thickness_m() const { return 3.5 * (far_m - near_m); }  ///< of the shell in which it grows [m]
};

/// Remeshes a surface to triangles of wanted sizes. Long sides are split, short sides collapsed, sides flipped and
/// nodes moved along the surface (Botsch and Kobbelt 2004, A remeshing approach to multiresolution modeling). Nodes
/// stay on the base surface. Creases and borders between labels remain lines of sides. Where the surface is curved, the
/// wanted length is at most 0.6 of the radius of curvature, but not less than near_m for this reason. On a border
/// between labels of the base surface it is at most 1/16 of the border's length.
class SurfaceRemesh {
   public:
    /// crease: cosine of an angle; edges that turn by more than it are kept. -1: only borders between labels are kept.
    /// A flip then still changes no normal by more than 40 degrees and makes no edge that turns by more (flat triangles
    /// excepted).
    SurfaceRemesh(const Surface& base, const SideLength& wanted, double crease = crease_cosine);

    /// Each round splits, collapses, flips and moves. Deterministic.
    void remesh(int rounds);

    /// Makes a position on the surface [m] a node that no longer moves. Result: number of the node.
    int insert(const Eigen::Vector3d& position_m);

    /// Cuts out a disc: the part of the surface within radius_m [m] of the node `centre` and connected to it. Its rim
    /// becomes a closed line of sides, and the triangles inside get disc_label. Throws MismatchError if a triangle
    /// inside is fixed, if the disc covers the surface, or if it is not one patch with one rim.
    void cut(int centre, double radius_m);

    /// The remeshed surface, with new node numbers.
    Surface surface() const;

   private:
    struct Triangle {
        std::array<int, 3> node;
        int label;
        bool alive;
    };
    using Side = std::uint64_t;
    static Side side(int a, int b) { return (static_cast<Side>(static_cast<std::uint32_t>(std::min(a, b))) << 32) | static_cast<std::uint32_t>(std::max(a, b)); }

    const Eigen::Vector3d& at(int node) const { return place_[static_cast<std::size_t>(node)]; }
    const std::array<int, 3>& corners(int t) const { return triangles_[static_cast<std::size_t>(t)].node; }
    std::vector<int>& around(int node) { return around_[static_cast<std::size_t>(node)]; }
    const std::vector<int>& around(int node) const { return around_[static_cast<std::size_t>(node)]; }
    Eigen::Vector3d twice_area(int t) const;
    double quality(int t) const;
    double wanted(int a, int b) const;
    double length(int a, int b) const { return (at(a) - at(b)).norm(); }
    int lines_at(int node) const;             ///< number of line sides at a node
    std::vector<int> neighbours(int node) const;  ///< ascending
    std::vector<std::array<int, 2>> sides() const;
    std::array<int, 2> triangles_at(int a, int b) const;  ///< left, with a before b, and right of side ab; -1: none
    int opposite(int t, int a, int b) const;
    bool is_line(int a, int b) const { return lines_.count(side(a, b)) > 0; }
    bool is_rim(int a, int b) const { return rim_.count(side(a, b)) > 0; }
    Eigen::Vector3d outward(int node) const;
    /// The position projected onto the base surface, its lines or the rim. limit_m: if not null, gets the size limit
    /// there; on the rim that of the last surface point.
    Eigen::Vector3d projected(const Eigen::Vector3d& position_m, const Eigen::Vector3d& outward, bool on_line, bool on_rim, double* limit_m) const;
    bool moves_well(int node, const Eigen::Vector3d& to_m) const;

    int split(int a, int b, const Eigen::Vector3d& to_m, double limit_m);
    bool collapse(int gone, int kept);
    bool flip(int a, int b);
    void move(int node);
    void split_long();
    void collapse_short();
    void flip_all();
    void limit_on_borders(const std::vector<std::array<int, 2>>& lines);
    void pin_corners();

    Surface base_;
    NearestTriangle nearest_;
    Cells base_lines_;                 ///< kept lines, as base nodes (L x 2)
    std::vector<double> base_limit_m_;  ///< largest wanted length at base nodes, by curvature and borders
    SideLength wanted_;

    std::vector<Eigen::Vector3d> place_;
    std::vector<double> limit_m_;
    std::vector<char> pinned_;
    std::vector<std::vector<int>> around_;  ///< triangles at each node
    std::vector<Triangle> triangles_;
    std::unordered_set<Side> lines_, rim_;  ///< the rim's sides are in lines_ too
    Eigen::Vector3d rim_centre_m_{0, 0, 0};
    double rim_radius_m_ = 0;
};

}  // namespace tissue
