#include "eval/solid_force_table.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

constexpr double unit_m = 0.020, unit_angle = 30 * 3.14159265358979323846 / 180, unit_depth_m = 0.006, blunt = 0.05;

}  // namespace

ForceTable::Entry SolidForceTable::at(const Point& contact_m, const Point& direction, double depth_m) const {
    // normal equations (sum w d d' + small) S' = sum w d F', with 1 / |d|^2 in w
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero(), products = squares;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Push& p : pushes_) {
        const double angle = std::acos(std::clamp(p.direction.dot(Eigen::Vector3d(direction)), -1.0, 1.0));
        const double s2 = (p.contact_m - Eigen::Vector3d(contact_m)).squaredNorm() / (unit_m * unit_m) +
                          angle * angle / (unit_angle * unit_angle) + std::pow((p.depth_m - depth_m) / unit_depth_m, 2);
        nearest = std::min(nearest, s2);
        const double weight = 1 / ((blunt + s2) * (blunt + s2)) / (p.depth_m * p.depth_m);
        const Eigen::Vector3d d = p.depth_m * p.direction;
        squares += weight * d * d.transpose();
        products += weight * d * p.force_N.transpose();
    }
    // regularises directions that no training indentation has
    squares += 1e-6 * squares.trace() * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d force = squares.ldlt().solve(products).transpose() * (depth_m * Eigen::Vector3d(direction));
    return {force, nearest > 1};
}

}  // namespace tissue
