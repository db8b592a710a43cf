#pragma once

#include <array>
#include <vector>

#include "mesh/outline.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Which spring sets serve a contact, and with which weights: not negative, summing to 1.
struct SetWeights {
    int count = 0;
    std::array<int, 8> set{};        ///< rows of theta
    std::array<double, 8> weight{};
    bool extrapolated = false;       ///< the contact lies outside what the sets were trained on; the nearest serve
};

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

    /// Linear in arc length between trained positions, in angle between the pushes trained at each, in depth between
    /// those trained along each; below the smallest depth the smallest serves.
    SetWeights blended(double arc_m, const Eigen::Vector2d& direction, double depth_m) const;

    /// The one set that is nearest in position, then in angle, then in depth: the paper's choice.
    SetWeights nearest(double arc_m, const Eigen::Vector2d& direction, double depth_m) const;

    /// True when every trained position knows several pushes: there is something to blend between everywhere. The paper
    /// has one push at its midpoints.
    bool dense() const;

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

/// Sum of the weighted sets: sum_i weight_i theta_(set_i) [N/m] (S).
Eigen::VectorXd blend(const NodeField& theta, const SetWeights& weights);

}  // namespace tissue
