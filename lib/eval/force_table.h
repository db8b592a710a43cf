#pragma once

#include <vector>

#include "eval/table_pushes.h"
#include "mesh/outline.h"

namespace tissue {

/// No springs at all: FE's own training forces by place, angle and depth of the push, linear in each between those that
/// were solved. The baseline at equal FE cost; it has no shape and no motion.
class ForceTable {
   public:
    /// pushes: in any order, at least one. Angles and depths need not be the same from place to place.
    ForceTable(const Outline& outline, const std::vector<TablePush>& pushes);

    struct Entry {
        Point force_N;             ///< on the tissue (D)
        bool extrapolated;         ///< the push lies outside what was solved: the nearest there is serves
    };
    /// At an arc length [m], along a unit direction, that deep [m]. Below the smallest depth it shrinks in proportion.
    Entry at(double arc_m, const Eigen::Vector2d& direction, double depth_m) const;

   private:
    struct Push {
        double angle;                          ///< off the inward normal of its place [rad]
        std::vector<double> depth_m;           ///< ascending
        std::vector<Eigen::Vector2d> force_N;
    };
    struct Place {
        double arc_m;
        std::vector<Push> pushes;              ///< ascending angle
    };
    static Entry along(const Push& push, double depth_m);

    Outline outline_;
    std::vector<Place> places_;                ///< ascending arc
};

}  // namespace tissue
