#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace tissue {

/// A round contact that grows and shrinks without slip while the tool moves along the surface. Each ring is bound at
/// the tool's position at the time when the contact reaches it, and is released when the contact shrinks below it. The
/// tangential stiffness is proportional to the radius, so each ring contributes in proportion to its width. The total
/// force is that of one spring, stretched from the mean of the places where the rings were bound (Mindlin 1949; Mindlin
/// and Deresiewicz 1953, no slip).
/// A contact that is stretched by more than its radius slips by the excess. Rings have a finite width, so a contact
/// that starts to grow again releases part of its outermost ring; this only dissipates energy. Allocates nothing.
class BoundRings {
   public:
    BoundRings() = default;
    /// A new contact of radius radius_m with the tool at tool_m. largest_m: upper bound of the radius. All in [m].
    BoundRings(double largest_m, double radius_m, const Eigen::Vector3d& tool_m) : width_m_(largest_m / (count - 1)), radius_m_(radius_m), front_m_(tool_m) {
        bound_m_.colwise() = tool_m;
    }

    /// The contact gets the radius radius_m while the tool is at tool_m [m].
    void follow(double radius_m, const Eigen::Vector3d& tool_m) noexcept {
        if (radius_m > radius_m_) {
            // radii are interpolated by their squares, which are proportional to a ball's depth
            const double from = radius_m_ * radius_m_, way = radius_m * radius_m - from;
            for (int k = inside() + 1; k < count && k * width_m_ <= radius_m; ++k) bound_m_.col(k) = front_m_ + (k * k * width_m_ * width_m_ - from) / way * (tool_m - front_m_);
            front_m_ = tool_m;
        } else if (radius_m < radius_m_) {
            const int last = inside(), k = std::min(static_cast<int>(radius_m / width_m_), last);
            const double from_m = k * width_m_, to_m = k < last ? from_m + width_m_ : radius_m_;
            const Eigen::Vector3d to = k < last ? Eigen::Vector3d(bound_m_.col(k + 1)) : front_m_;
            if (to_m > from_m) front_m_ = bound_m_.col(k) + (radius_m - from_m) / (to_m - from_m) * (to - bound_m_.col(k));
        }
        radius_m_ = radius_m;
        const Eigen::Vector3d stretch = tool_m - mean_m();
        if (const double excess = stretch.norm() - radius_m; excess > 0) {
            const Eigen::Vector3d slip = excess / stretch.norm() * stretch;
            bound_m_.colwise() += slip;
            front_m_ += slip;
        }
    }

    /// Mean of the places where the rings were bound [m].
    Eigen::Vector3d mean_m() const noexcept {
        const int last = inside();
        Eigen::Vector3d sum = (radius_m_ - last * width_m_) / 2 * (bound_m_.col(last) + front_m_);
        for (int k = 0; k < last; ++k) sum += width_m_ / 2 * (bound_m_.col(k) + bound_m_.col(k + 1));
        return radius_m_ > 0 ? Eigen::Vector3d(sum / radius_m_) : front_m_;
    }

    template <class State>
    void fields(State& state) noexcept { state(width_m_, radius_m_, front_m_, bound_m_); }

   private:
    static constexpr int count = 64;
    /// index of the outermost whole ring
    int inside() const noexcept { return std::min(static_cast<int>(radius_m_ / width_m_), count - 1); }

    double width_m_ = 1, radius_m_ = 0;
    Eigen::Vector3d front_m_ = Eigen::Vector3d::Zero();  ///< where the rim of the contact was bound
    /// where the rings at 0, 1, 2, ... widths from the centre were bound
    Eigen::Matrix<double, 3, count> bound_m_ = Eigen::Matrix<double, 3, count>::Zero();
};

}  // namespace tissue
