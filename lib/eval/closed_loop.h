#pragma once

#include <optional>
#include <string>
#include <vector>

#include "springs/equilibrium.h"

namespace tissue {

/// A contact at which FE knows the force: where, how far pushed, and the force.
struct ContactTruth {
    SurfacePoint contact;
    Eigen::VectorXd push_m;   ///< d (D)
    Eigen::VectorXd force_N;  ///< r_fe (D)
};

/// The error a hand feels: the contact held at d, everything else at rest, e = |r_model - r_fe| / |r_fe|.
/// Nothing when the spring mesh has no equilibrium there; `status` says why.
std::optional<double> closed_loop_error(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                                        const ContactTruth& truth, EquilibriumStatus& status);

/// The same of any model's answer there.
std::optional<double> closed_loop_error(const Equilibrium& answer, const ContactTruth& truth);

/// Reasons of those that are not `balanced`, each with how many have it, on one line; empty when all are.
std::string reasons_of(const std::vector<EquilibriumStatus>& statuses);

/// The honest baseline: the one stiffness for the whole mesh [N/m] (diagonals half) with the smallest median
/// closed-loop error over `truths`, found on a logarithmic grid of 1 % steps between low and high [N/m].
/// Contacts without an equilibrium (whatever the stiffness) are left out; nothing when they are more than half.
std::optional<double> best_uniform_stiffness(const SpringMesh& mesh, const SpringLaw& law,
                                             const std::vector<ContactTruth>& truths, double low_N_m, double high_N_m);

}  // namespace tissue
