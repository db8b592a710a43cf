#include "study/solid_push.h"

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
    // + 0: no -0 among a load path's arguments
    const Eigen::Vector3d push(sine(tilt_deg) * cosine(azimuth_deg) + 0.0, sine(tilt_deg) * sine(azimuth_deg) + 0.0, -cosine(tilt_deg) + 0.0);
    return push.normalized();
}

}  // namespace tissue
