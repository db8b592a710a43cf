#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "mesh/nearest_triangle.h"
#include "mesh/surface.h"

namespace tissue {

/// Wanted length of a side: near_m within radius_m of a place, from there growing to far_m, as gmsh's field Ball does.
struct SideLength {
    Eigen::Vector3d centre_m;
    double radius_m, near_m, far_m;

    double at(const Eigen::Vector3d& position_m) const;
    double thickness_m() const { return 3.5 * (far_m - near_m); }  ///< over which it grows
};

/// A surface divided anew into triangles of wanted sizes: long sides are split, short ones collapsed, sides flipped and nodes
/// moved along the surface (Botsch and Kobbelt 2004, A remeshing approach to multiresolution modeling). Nodes stay on the
/// surface that it was made of; creases and borders between labels stay lines of sides. Where the surface is curved, sides
/// are no longer than 0.6 of its radius.
class SurfaceRemesh {
   public:
    /// crease: cosine of the angle by which neighbours turn at least at an edge that is kept; -1: those between labels alone are (a flip still turns no edge that turns by more than 40 degrees).
    SurfaceRemesh(const Surface& base, const SideLength& wanted, double crease = crease_cosine);

    /// One round is a pass of each operation. Deterministic.
    void remesh(int rounds);

    /// Makes a place on the surface a node that stays. Returns its number.
    int insert(const Eigen::Vector3d& position_m);

    /// Makes |x - x_centre| = radius_m a closed line of sides, as far as the surface about the node `centre` reaches it,
    /// and labels what is inside disc_label. Throws MismatchError where that is held, or no one patch with one rim.
    void cut(int centre, double radius_m);

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
    int lines_at(int node) const;             ///< lines' sides at a node
    std::vector<int> neighbours(int node) const;  ///< ascending
    std::vector<std::array<int, 2>> sides() const;
    std::array<int, 2> triangles_at(int a, int b) const;  ///< left, with a before b, and right
    int opposite(int t, int a, int b) const;
    bool is_line(int a, int b) const { return lines_.count(side(a, b)) > 0; }
    bool is_rim(int a, int b) const { return rim_.count(side(a, b)) > 0; }
    Eigen::Vector3d outward(int node) const;
    /// On the base surface, its lines or the rim.
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
    Cells base_lines_;                 ///< of base nodes (L x 2)
    std::vector<double> base_limit_m_;  ///< by curvature, of base nodes
    SideLength wanted_;

    std::vector<Eigen::Vector3d> place_;
    std::vector<double> limit_m_;
    std::vector<char> pinned_;
    std::vector<std::vector<int>> around_;  ///< triangles of each node
    std::vector<Triangle> triangles_;
    std::unordered_set<Side> lines_, rim_;  ///< the rim is a line, too
    Eigen::Vector3d rim_centre_m_{0, 0, 0};
    double rim_radius_m_ = 0;
};

}  // namespace tissue
