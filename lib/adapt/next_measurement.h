#pragma once

#include <functional>
#include <vector>

#include "adapt/adaptation.h"

namespace tissue {

/// A possible indentation: contact and tool displacement [m].
struct Push {
    Point contact_m, push_m;  ///< (D)
};

constexpr double usual_depth_m = 0.006;  ///< default depth of a suggested indentation

/// Indentations along the inward normal, of depth depth_m, spread over the free surface: at least 0.95 apart_m from
/// each other and apart_m from fixed nodes. Throws MismatchError for a depth that is not above 0 or not finite.
std::vector<Push> pushes_over(const FreeSurface& surface, const SpringMesh& mesh, double depth_m, double apart_m);

/// Information that the measurement of one indentation would give on the forces of others.
struct MeasurementGain {
    std::size_t push;     ///< index among the possible indentations
    /// relative reduction of the mean variance of the judged forces (each over its size): the part due to the unknowns
    double gain;
    double sd_before;     ///< standard deviation of its own force before the measurement, over its size (covariance())
};

/// Ranks the possible indentations may_be by `gain`, the largest first. The covariance of the filter depends on the
/// noise of a measurement and not on its value, so gains are known in advance. They are those of the field also while
/// the uniform scale is in use, whose variance a measurement reduces alike at any place. judged: indentations whose forces are to
/// be predicted. Indentations without an equilibrium are left out. between: called before each equilibrium solve, one
/// for each entry of may_be and judged; may throw to stop.
std::vector<MeasurementGain> rank_measurements(Adaptation& adaptation, const std::vector<Push>& may_be, const std::vector<Push>& judged,
                                  const std::function<void()>& between = {});

}  // namespace tissue
