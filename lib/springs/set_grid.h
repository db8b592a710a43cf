#pragma once

#include <vector>

#include "mesh/outline.h"
#include "springs/tissue_model.h"

namespace tissue {

/// The trained contacts as a grid that a contact is looked up in: position along the surface, direction of the push,
/// depth. The paper's Sec. 4.3 by contact position, angle and displacement. Look-ups allocate nothing and never throw.
class SetGrid {
   public:
    /// contact_m, direction (C x D), depth_m (C): where each set was trained, along which push, how deep. Depths may be
    /// of any other measure that look-ups are made by (Sec. 4.3: the force [N]).
    SetGrid(const SpringMesh& mesh, const NodeField& contact_m, const NodeField& direction, const Eigen::VectorXd& depth_m);

    /// The model's load cases, by depth.
    explicit SetGrid(const TissueModel& model)
        : SetGrid(model.mesh, model.contact_m, model.direction, model.magnitude_m) {}

    /// The one set that is nearest in position, then in angle, then in depth: the paper's choice. A row of theta.
    int nearest(double arc_m, const Eigen::Vector2d& direction, double depth_m) const;

    const Outline& outline() const { return outline_; }

   private:
    struct Push {
        double angle;                ///< off the inward normal of its position [rad]
        std::vector<double> depth;   ///< ascending [m]
        std::vector<int> set;
    };
    struct Position {
        double arc;
        std::vector<Push> pushes;    ///< ascending angle
    };

    Outline outline_;
    std::vector<Position> positions_;  ///< ascending arc
};

}  // namespace tissue
