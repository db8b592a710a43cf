#pragma once

#include <vector>

#include "eval/force_table.h"

namespace tissue {

/// No springs at all, in space: FE's own training forces near a push say what stiffness S there is, F = S d, by least squares
/// of F / |d| over all of them and their mirror images, each square weighted with 1 / (0.05 + s^2)^2, where s counts its distance in units of
/// 20 mm, 30 degrees of direction and 6 mm of depth. The baseline at equal FE cost; it has no shape and no motion.
class SolidForceTable {
   public:
    /// At least one.
    explicit SolidForceTable(const std::vector<TablePush>& pushes) : pushes_(pushes.begin(), pushes.end()) {}

    /// extrapolated: no training push is nearer than s = 1.
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
