#pragma once

#include <vector>

#include "eval/table_pushes.h"
#include "mesh/outline.h"

namespace tissue {

/// Baseline without springs, at equal FE cost: a table of the FE training forces, interpolated linearly in place, angle
/// and depth. It predicts no displacement field and no dynamics. Two dimensions.
class ForceTable {
   public:
    /// pushes: the FE forces, in any order, at least one. Angles and depths may differ from place to place.
    ForceTable(const Outline& outline, const std::vector<TablePush>& pushes);

    struct Entry {
        Point force_N;             ///< of the tool on the tissue (D)
        bool extrapolated;         ///< outside the range of the table, where the nearest entry is used
    };
    /// Force at an arc length [m], along a unit direction, at a depth [m]. Below the smallest depth of the table the
    /// force is proportional to depth, and not marked as extrapolated.
    Entry at(double arc_m, const Eigen::Vector2d& direction, double depth_m) const;

   private:
    struct Push {
        double angle;                          ///< to the inward normal at its place [rad]
        std::vector<double> depth_m;           ///< ascending
        std::vector<Eigen::Vector2d> force_N;
    };
    struct Place {
        double arc_m;
        std::vector<Push> pushes;              ///< by ascending angle
    };
    static Entry along(const Push& push, double depth_m);

    Outline outline_;
    std::vector<Place> places_;                ///< by ascending arc length
};

}  // namespace tissue
