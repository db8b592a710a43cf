#pragma once

#include "springs/spring_law.h"
#include "train/optimizer.h"

namespace tissue {

/// One contact whose force is known and nothing else: no displacement inside.
struct Reading {
    SurfacePoint contact;
    Eigen::VectorXd push_m, force_N;  ///< (D)
    double weight = 1;
};

/// Why a fit ended. F is the objective, p the fall of F that the last step's linear problem promised, f its fall.
enum class ReactionStatus {
    converged,       ///< 0 < f <= tolerance F, or p <= tolerance F: nothing worth a step is left
    stalled,         ///< p > tolerance F, but neither the step nor a half of it, nor a half of that ... lowers F
    iterations_done  ///< f > tolerance F at max_iterations
};

/// What a fit to readings ended with.
struct ReactionFit {
    Eigen::VectorXd theta;            ///< (S), inside the box
    std::vector<ForceLoss> losses;    ///< of each reading at `theta`: |r - (G A) theta'|, r(theta') to first order [N]
    ForceLoss inner;                  ///< the last linearised problem, with its ridge, times the first reading: convex, so
                                      ///< certificates hold for it, and in the unit of losses.front() [N]
    int iterations = 0;
    ReactionStatus status = ReactionStatus::iterations_done;
};

struct ReactionOptions {
    int max_iterations = 30;          ///< measured: 3-8 are taken
    double tolerance = 1e-4;          ///< far below what noise leaves of the objective
};

/// min sum_i weight_i (|r_i(theta) - r_i| / |r_i|)^2 + ridge c |theta - theta0|^2 over the box, where r_i(theta) is the closed loop's
/// own answer: the contact held at push_i, every other node at its own equilibrium u(theta). c is the mean squared column
/// of the first linearisation, so that ridge is a pure number.
///
/// Gauss-Newton. Free nodes carry no force at u(theta), so r(theta') = G A(u) theta' + O(|theta' - theta|^2) with G the
/// compliance of contact_sensitivity, exactly at theta' = theta: each step is a bounded linear least squares problem
/// (bounded_lsq.h), shortened until the objective itself falls. The whole is not convex: no certificate covers it, only
/// its last step's.
///
/// A reading without a force has no relative error and does not count.
/// start, theta0 (S) inside the box. Throws MismatchError when the mesh has no equilibrium at `start`.
ReactionFit fit_reactions(const SpringMesh& mesh, const SpringLaw& law, const std::vector<Reading>& readings,
                          const Eigen::VectorXd& start, const Eigen::VectorXd& theta0, double ridge, const Box& box,
                          const ReactionOptions& options = {});

/// The factor of `theta` with the smallest sum of squared relative errors over the readings: r(theta) is proportional to
/// theta. Throws MismatchError when the mesh has no equilibrium, or no reading a force.
double best_factor(const SpringMesh& mesh, const SpringLaw& law, const std::vector<Reading>& readings,
                   const Eigen::VectorXd& theta);

}  // namespace tissue
