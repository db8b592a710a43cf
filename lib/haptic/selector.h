#pragma once

#include <Eigen/Core>
#include <vector>

#include "springs/set_grid.h"
#include "springs/tissue_model.h"

namespace tissue {

/// By what the sets are told apart at one place; force: Sec. 4.3 as printed.
enum class SelectBy { displacement, force };

/// Sec. 4.3 in the tick: which spring set serves a contact, the nearest (SetGrid::nearest, the evaluation's own). A function
/// of contact position and x_p - X_p; by force: of the force on the tissue there, compared with the forces that the sets
/// themselves give at their load cases. Constants only; select() does not allocate.
class Selector {
   public:
    /// theta (C x S): the sets in use. Throws MismatchError when the model has none, or (by force) one has no
    /// equilibrium under its own load case.
    Selector(const TissueModel& model, const Eigen::Ref<const NodeField>& theta, SelectBy by);

    /// segment, w: of the outline at rest. push: x_p - X_p [m], or the force on the tissue [N]. A push below a hundredth
    /// of the smallest trained one has no direction worth the name: it is filled up to that along the inward normal.
    int select(int segment, double w, const Eigen::Vector2d& push) const noexcept;

   private:
    Selector(const TissueModel& model, const Eigen::VectorXd& sizes);

    SetGrid grid_;
    std::vector<Eigen::Vector2d> outline_m_, normal_;  ///< rest positions of outline nodes; inward normals of segments (M)
    double small_;  ///< a hundredth of the smallest trained push
};

}  // namespace tissue
