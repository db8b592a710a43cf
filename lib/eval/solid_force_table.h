#pragma once

#include <vector>

#include "cases/load_path.h"
#include "eval/force_table.h"

namespace tissue {

/// No springs at all, in space: FE's own training forces near a push say what stiffness S there is, F = S d, by least squares
/// over all of them, each weighted with 1 / (0.05 + s^2)^2, where s counts its distance in units of 20 mm, 30 degrees of
/// direction and 6 mm of depth. The rival at equal FE cost; it knows no shape and no motion.
class SolidForceTable {
   public:
    /// loads: at least one.
    explicit SolidForceTable(const std::vector<LoadCase>& loads);

    /// extrapolated: no training push is nearer than s = 1.
    ForceTable::Entry at(const Point& contact_m, const Point& direction, double depth_m) const;

   private:
    struct Push {
        Eigen::Vector3d contact_m, direction, force_N;
        double depth_m;
    };
    std::vector<Push> pushes_;
};

}  // namespace tissue
