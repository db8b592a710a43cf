#pragma once

#include <Eigen/Core>
#include <string>

namespace tissue {

/// Sec. 4.4: the device's space on the plane of the tissue. The paper ignores motion in and out of the image; so do
/// we, for whichever axes are left out.
struct DeviceMap {
    Eigen::Matrix<double, 2, 3> axes = Eigen::Matrix<double, 2, 3>::Identity();  ///< device axes of the plane's x and y
    double scale = 1;                                      ///< metres of tissue a metre of device
    Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();    ///< of the device's origin in the plane
    double force_scale = 1;                                ///< newtons on the hand a newton of tissue

    Eigen::Vector2d to_plane(const Eigen::Vector3d& position_m) const noexcept {
        return scale * (axes * position_m) + offset_m;
    }
    Eigen::Vector3d force_to_device(const Eigen::Vector2d& force_N) const noexcept {
        return force_scale * (axes.transpose() * force_N);
    }
    /// A device position that maps to this point of the plane.
    Eigen::Vector3d to_device(const Eigen::Vector2d& point_m) const noexcept {
        return axes.transpose() * (point_m - offset_m) / scale;
    }
};

/// "x,y", "x,-z", ...: the device axes that become the plane's x and y. Throws MismatchError when they are not two
/// different ones.
Eigen::Matrix<double, 2, 3> parse_axes(const std::string& text);

}  // namespace tissue
