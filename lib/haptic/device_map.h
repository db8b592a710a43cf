#pragma once

#include <Eigen/Core>
#include <string>

#include "field.h"
#include "haptic/state_bytes.h"

namespace tissue {

/// Sec. 4.4: the device's space on that of the tissue, D = 2 axes in the plane, 3 in space. The paper ignores motion in and out of
/// the image; so do we in the plane, for whichever axis is left out.
struct DeviceMap {
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> axes = decltype(axes)(0, 3);  ///< device axes of the tissue's (D x 3); no rows: the first ones
    Point rotation_rad;                   ///< of the device in the axes that it says, before `axes`: a turn by its length about its direction (3); empty: none
    double scale = 1;                     ///< metres of tissue a metre of device
    Point offset_m;                       ///< of the device's origin in the tissue's space (D); empty: none
    double force_scale = 1;               ///< newtons on the hand a newton of tissue

    /// For a tissue of so many axes; again after another field has changed. Throws MismatchError when axes, rotation or offset are of another number.
    void fit(int dimension);

    Point to_tissue(const Eigen::Vector3d& position_m) const noexcept { return scale * (turn_ * position_m) + offset_m; }
    Eigen::Vector3d force_to_device(const Point& force_N) const noexcept { return force_scale * (turn_.transpose() * force_N); }
    /// A force in the device's axes as one on a tissue of that size: newtons are newtons.
    Point force_to_tissue(const Eigen::Vector3d& force_N) const noexcept { return turn_ * force_N; }
    /// The other way round.
    Eigen::Vector3d force_from_tissue(const Point& force_N) const noexcept { return turn_.transpose() * force_N; }
    /// A device position that maps to this point.
    Eigen::Vector3d to_device(const Point& point_m) const noexcept { return turn_.transpose() * (point_m - offset_m) / scale; }

    bool same_as(const DeviceMap& other) const { return turn_ == other.turn_ && scale == other.scale && offset_m == other.offset_m; }  ///< takes positions to the same places

    void fields(StateBytes& state) noexcept { state(axes, rotation_rad, scale, offset_m, force_scale, turn_); }

   private:
    decltype(axes) turn_ = decltype(axes)(0, 3);  ///< axes, of the device as it is turned
};

/// "x,-z" in the plane, "x,-z,y" in space, ...: the device axes that become the tissue's (D x 3). Throws MismatchError when they
/// are not two or three different ones.
Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> parse_axes(const std::string& text);

}  // namespace tissue
