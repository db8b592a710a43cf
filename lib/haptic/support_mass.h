#pragma once

#include <Eigen/Core>

#include "springs/tissue_model.h"

namespace tissue {

/// Masses that a law's tick moves [kg] (N): the model's, and at corners of cubes that stiff supports hold more, so that supports do not make steps smaller.
///
/// A support of stiffness k holds sum_j w_j u_j over the n corners of its cube that have a weight. By Cauchy and Schwarz k |sum_j w_j u_j|^2 <= n k sum_j w_j^2 |u_j|^2, so that with
/// n k w_j^2 / Omega^2 more at every corner j no mode of springs and supports is faster than Omega, the fastest of the springs and cubes alone. What a stiff support holds hardly moves, and neither does this mass:
/// a force at rest does not change. Where corners may swing about a support against each other, as in cubes of which little is tissue, it would move: without a bound the slowest mode of a dome
/// in cubes of 11 mm becomes slower by 20 %. So no corner gets more than `most` of its own stiffness / Omega^2, and `most` goes down from 1500 until the tissue's slowest mode is within half a per cent of what
/// it is without. On blocks nothing is cut; on such a dome, with supports 50 times as stiff as they start, modes then are up to 1.45 Omega fast, in place of 5.7.
/// The model's own masses come back where supports raise the fastest frequency by less than 5 %, where the lattice has no slowest mode, and where the least `most`, 1, still slows it: steps then are as small
/// as the supports ask for. Kinetic energy of a session counts this mass.
Eigen::VectorXd mass_with_supports(const TissueModel& model);

}  // namespace tissue
