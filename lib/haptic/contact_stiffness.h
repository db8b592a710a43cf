#pragma once

#include <Eigen/Core>
#include <vector>

#include "haptic/realtime_mesh.h"

namespace tissue {

/// Stiffness of a spring mesh at each place of its outline: force over displacement of a contact there, at rest, as the
/// mean over the axes, with the spring set that is selected at a first touch. The virtual coupling k_C is a multiple of
/// it (HapticOptions::coupling_ratio).
class ContactStiffness {
   public:
    /// first_set: index of the set that is selected at a first touch of each segment of the outline (M).
    /// theta_of_set: stiffness by slot, one column a set [N/m] (P x C).
    ContactStiffness(const RealtimeMesh& mesh, const std::vector<int>& first_set, const Eigen::MatrixXd& theta_of_set);

    /// Stiffness at weight w of a segment of the outline [N/m], at most largest(). w: 0 at its first node, 1 at its
    /// second. Allocates nothing.
    double at(int segment, double w) const noexcept;

    /// Stiffness at the stiffest free node of the outline [N/m].
    double largest() const { return largest_; }

    /// Number of segments of the outline without a stiffness of their own, which have that of the mean spring instead:
    /// the stiffness matrix of their set is singular (zero-energy modes), or it is too large to factor (256 MB).
    int without_stiffness() const { return without_stiffness_; }

   private:
    /// Compliance of each segment: coefficients of w0^2, w1^2 and w0 w1, of the weights of its ends [m/N] (M).
    std::vector<double> first_, second_, mixed_;
    double largest_ = 0;
    int without_stiffness_ = 0;
};

}  // namespace tissue
