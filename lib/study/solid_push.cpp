#include "study/solid_push.h"

#include <Eigen/Geometry>
#include <cmath>

namespace tissue {
namespace {

double cosine(double angle_deg) {
    constexpr double degree = 3.14159265358979323846 / 180;
    return std::abs(std::remainder(angle_deg, 360)) == 90 ? 0 : std::cos(angle_deg * degree);
}

double sine(double angle_deg) { return cosine(angle_deg - 90); }

}  // namespace

Point solid_push(double tilt_deg, double azimuth_deg) {
    // + 0.0 turns -0 into 0 for a load path's arguments
    const Eigen::Vector3d push(sine(tilt_deg) * cosine(azimuth_deg) + 0.0, sine(tilt_deg) * sine(azimuth_deg) + 0.0, -cosine(tilt_deg) + 0.0);
    return push.normalized();
}

Point surface_push(const Point& inward, double tilt_deg, double azimuth_deg) {
    constexpr double nearly_along = 0.9;  // about cos 26 degrees
    const Eigen::Vector3d n = inward, axis = Eigen::Vector3d::Unit(std::abs(n[0]) > nearly_along ? 1 : 0);
    const Eigen::Vector3d t1 = (axis - axis.dot(n) * n).normalized(), t2 = t1.cross(n);
    const Point on_block = solid_push(tilt_deg, azimuth_deg);
    return Eigen::Vector3d(on_block[0] * t1 + on_block[1] * t2 - on_block[2] * n).normalized();
}

}  // namespace tissue
