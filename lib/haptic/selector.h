#pragma once

#include <Eigen/Core>
#include <vector>

#include "springs/set_grid.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Quantity by which the sets at one place are distinguished; force: Sec. 4.3 as printed.
enum class SelectBy { displacement, force };

/// Selects the spring set of a contact in the tick (Sec. 4.3): the nearest one, by SetGrid::nearest as in evaluation.
/// It depends on contact position and x_p - X_p. By force: on the force on the tissue in place of x_p - X_p, compared
/// with the forces of the sets at their own load cases. Constants only; select() does not allocate.
class Selector {
   public:
    /// theta [N/m] (C x S): the sets in use. Throws MismatchError where the model has no sets, or (by force) a set has
    /// no equilibrium under its own load case.
    Selector(const TissueModel& model, const Eigen::Ref<const NodeField>& theta, SelectBy by);

    /// Number of the set, a row of theta. segment, w: place on the outline at rest. push: x_p - X_p [m], or the force
    /// on the tissue [N]. A push below a hundredth of the smallest trained one has no reliable direction: its missing
    /// length is added along the inward normal.
    int select(int segment, double w, const Eigen::Vector2d& push) const noexcept;

   private:
    Selector(const TissueModel& model, const Eigen::VectorXd& sizes);

    SetGrid grid_;
    /// rest positions of outline nodes; inward normals of segments (M)
    std::vector<Eigen::Vector2d> outline_m_, normal_;
    double small_;  ///< a hundredth of the smallest trained push [m], or force [N]
};

}  // namespace tissue
