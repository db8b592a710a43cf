#pragma once

#include <Eigen/Core>
#include <string>

#include "field.h"
#include "haptic/state_bytes.h"

namespace tissue {

/// Sec. 4.4: map from the device's space to the tissue's space, D = 2 axes in the plane, 3 in space:
///     x = scale axes R x_device + offset, with R the rotation.
/// The paper ignores motion in and out of the image. In the plane this map ignores the axis that is left out.
struct DeviceMap {
    /// Row d is the signed device axis that becomes axis d of the tissue (D x 3). No rows: the first D axes.
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> axes = decltype(axes)(0, 3);
    /// Rotation vector in the device's axes, applied before `axes`: its length is the angle, its direction the axis
    /// (3). Empty: no rotation.
    Point rotation_rad;
    double scale = 1;                     ///< tissue displacement over device displacement
    Point offset_m;                       ///< position of the device's origin in the tissue's space (D); empty: zero
    double force_scale = 1;               ///< device force over tissue force

    /// Completes the map for a tissue of D = dimension axes. To be called again after a field has changed. Throws
    /// MismatchError when axes, offset or rotation have the wrong size, or the rotation a component above 100 rad.
    void fit(int dimension);

    Point to_tissue(const Eigen::Vector3d& position_m) const noexcept { return scale * (turn_ * position_m) + offset_m; }
    Eigen::Vector3d force_to_device(const Point& force_N) const noexcept { return force_scale * (turn_.transpose() * force_N); }
    /// Rotates a force from the device's axes to the tissue's (D). Its size stays: force_scale is not applied.
    Point force_to_tissue(const Eigen::Vector3d& force_N) const noexcept { return turn_ * force_N; }
    /// The inverse of force_to_tissue (3).
    Eigen::Vector3d force_from_tissue(const Point& force_N) const noexcept { return turn_.transpose() * force_N; }
    /// A device position that maps to this point (3); in the plane its component along the axis that is left out is 0.
    Eigen::Vector3d to_device(const Point& point_m) const noexcept { return turn_.transpose() * (point_m - offset_m) / scale; }

    /// Whether both maps take positions to the same places. force_scale may differ.
    bool same_as(const DeviceMap& other) const { return turn_ == other.turn_ && scale == other.scale && offset_m == other.offset_m; }

    void fields(StateBytes& state) noexcept { state(axes, rotation_rad, scale, offset_m, force_scale, turn_); }

   private:
    decltype(axes) turn_ = decltype(axes)(0, 3);  ///< axes R (D x 3)
};

/// Reads DeviceMap::axes (D x 3) from text, such as "x,-z" in the plane and "x,-z,y" in space. Throws MismatchError
/// when the text is not two or three different axes x, y, z, each with an optional sign.
Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> parse_axes(const std::string& text);

}  // namespace tissue
