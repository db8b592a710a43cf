#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace tissue {

/// A point of the outline: segment b between outline nodes b and b + 1, x = (1 - w) s_b(0) + w s_b(1), (16)-(17).
struct OutlinePoint {
    int segment = 0;
    double w = 0;                                        ///< w(1) of the paper; w(0) = 1 - w, both in [0, 1]
    Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
    double distance_m = 0;                               ///< from whatever was asked about
};

/// The closed outline of one mesh, counter-clockwise, as it stands in this tick. Storage is made once; nothing here
/// allocates or throws. Positions must be finite.
class MovingOutline {
   public:
    explicit MovingOutline(int segments);

    int segments() const { return count_; }
    /// Position of outline node b; refresh() after the last one.
    void set(int b, const Eigen::Vector2d& position_m) noexcept {
        x_[static_cast<std::size_t>(b)] = position_m.x();
        y_[static_cast<std::size_t>(b)] = position_m.y();
    }
    void refresh() noexcept;
    Eigen::Vector2d node(int b) const noexcept { return {x_[static_cast<std::size_t>(b)], y_[static_cast<std::size_t>(b)]}; }
    /// Point at weight w of a segment.
    Eigen::Vector2d at(int segment, double w) const noexcept { return (1 - w) * node(segment) + w * node(segment + 1); }

    /// True where an odd number of segments lies to the right; points on the outline may fall on either side.
    bool contains(const Eigen::Vector2d& p) const noexcept;

    /// Inside, and farther than tolerance_m from the outline.
    bool contains_strictly(const Eigen::Vector2d& p, double tolerance_m) const noexcept;

    /// The point of the outline nearest to p: argmin_i ||p - n(s_i)||.
    OutlinePoint nearest(const Eigen::Vector2d& p) const noexcept;

    /// Where the way from p to m crosses the outline, farthest from m: argmax_i ||m - int_i||. Nothing when it does not.
    std::optional<OutlinePoint> first_crossing(const Eigen::Vector2d& p, const Eigen::Vector2d& m) const noexcept;

    /// Whether no two segments cross or touch but neighbours at their common node: only then is there an inside.
    bool simple() noexcept;


   private:
    bool crosses(int a, int b) const noexcept;

    int count_;
    std::vector<double> x_, y_;                          ///< nodes, the first again at the end (M + 1)
    std::vector<double> low_x_, high_x_, low_y_, high_y_;  ///< boxes of the segments (M)
};

}  // namespace tissue
