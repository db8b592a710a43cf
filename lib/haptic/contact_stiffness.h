#pragma once

#include <Eigen/Core>
#include <vector>

#include "haptic/realtime_mesh.h"

namespace tissue {

/// How stiff each place of the outline is by itself: force over displacement of a contact pushed there at rest, mean of
/// the axes, with the spring set that serves a first touch. The virtual coupling k_C of springs is a multiple of it.
class ContactStiffness {
   public:
    /// first_set: that serves a first touch of each segment of the outline (M). theta_of_set: by slot, one column a set (P x C).
    ContactStiffness(const RealtimeMesh& mesh, const std::vector<int>& first_set, const Eigen::MatrixXd& theta_of_set);

    /// [N/m] at weight w of a segment of the outline; never above largest(). Does not allocate.
    double at(int segment, double w) const noexcept;

    /// At the stiffest free node of the outline [N/m].
    double largest() const { return largest_; }

    /// Nodes of the outline whose serving set has zero-energy modes: the mean spring stands in there.
    int floppy() const { return floppy_; }

   private:
    std::vector<double> first_, second_, mixed_;  ///< compliances of each segment: w0 w0, w1 w1, 2 w0 w1 [m/N] (M)
    double largest_ = 0;
    int floppy_ = 0;
};

}  // namespace tissue
