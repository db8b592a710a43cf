#pragma once

#include <vector>

#include "eval/force_table.h"

namespace tissue {

/// Baseline without springs in space, at equal FE cost: a local stiffness matrix S with F = S d, fitted to all FE
/// training forces by weighted least squares: minimise the sum of w |F - S d|^2 / |d|^2, w = 1 / (0.05 + s^2)^2. s is
/// the distance of a training indentation, in units of 20 mm of place, 30 degrees of direction and 6 mm of depth. It
/// predicts no displacement field and no dynamics.
class SolidForceTable {
   public:
    /// pushes: FE training forces and their mirror images (table_pushes), at least one.
    explicit SolidForceTable(const std::vector<TablePush>& pushes) : pushes_(pushes.begin(), pushes.end()) {}

    /// Force at a contact [m] (3), along a unit direction (3), at a depth [m]. extrapolated: every training indentation
    /// is farther than s = 1.
    ForceTable::Entry at(const Point& contact_m, const Point& direction, double depth_m) const;

   private:
    struct Push {
        Push(const TablePush& p) : contact_m(p.contact_m), direction(p.direction), force_N(p.force_N), depth_m(p.depth_m) {}
        Eigen::Vector3d contact_m, direction, force_N;
        double depth_m;
    };
    std::vector<Push> pushes_;
};

}  // namespace tissue
