#pragma once

#include <vector>

#include "mesh/outline.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Grid of the trained contacts, for look-up by position along the surface, direction and depth of the indentation.
/// Source: the paper's Sec. 4.3 (contact position, angle, displacement). Look-ups do not allocate and do not throw.
class SetGrid {
   public:
    /// contact_m, direction (C x D), depth_m (C): contact, direction and depth for which each set was trained. Another
    /// measure may replace the depth if look-ups use it too (Sec. 4.3: the force [N]).
    SetGrid(const SpringMesh& mesh, const NodeField& contact_m, const NodeField& direction, const Eigen::VectorXd& depth_m);

    /// Grid of the model's load cases, by depth.
    explicit SetGrid(const TissueModel& model)
        : SetGrid(model.mesh, model.contact_m, model.direction, model.magnitude_m) {}

    /// Row of theta of the set that is nearest in position, then in angle, then in depth: the paper's choice.
    int nearest(double arc_m, const Eigen::Vector2d& direction, double depth_m) const;

    const Outline& outline() const { return outline_; }

   private:
    struct Push {
        double angle;                ///< from the inward normal of its position [rad]
        std::vector<double> depth;   ///< ascending [m]
        std::vector<int> set;
    };
    struct Position {
        double arc;
        std::vector<Push> pushes;    ///< by ascending angle
    };

    Outline outline_;
    std::vector<Position> positions_;  ///< by ascending arc length
};

}  // namespace tissue
