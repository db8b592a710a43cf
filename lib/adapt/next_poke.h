#pragma once

#include <functional>
#include <vector>

#include "adapt/adaptation.h"

namespace tissue {

/// A push that may be made.
struct Push {
    Point contact_m, push_m;  ///< (D)
};

constexpr double usual_depth_m = 0.006;  ///< of a push that is told, where nobody says how deep

/// Pushes straight into the tissue, so deep, all over its free surface: about `apart_m` from each other, and as far from what is held. Throws
/// MismatchError for a depth that is not above 0, or not finite.
std::vector<Push> pushes_over(const FreeSurface& surface, const SpringMesh& mesh, double depth_m, double apart_m);

/// What a push would tell of others.
struct PokeWorth {
    std::size_t push;     ///< of those that may be made
    double gain;          ///< part of the mean variance of the others' forces, over their size, that it would take away
    double sd_before;     ///< of its own force, over its size, were it not made
};

/// Of pushes that may be made, worth most first: by the filter's covariance, in which a force's noise counts and its value does not.
/// judged: where the force is to be known. Pushes with no rest are left out. between: called before each press, of which there are as many as
/// pushes; may throw to end it.
std::vector<PokeWorth> rank_pokes(Adaptation& adaptation, const std::vector<Push>& may_be, const std::vector<Push>& judged,
                                  const std::function<void()>& between = {});

}  // namespace tissue
