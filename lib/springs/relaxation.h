#pragma once

#include <Eigen/Core>

#include "field.h"

namespace tissue {

struct LawModel;

/// How a law relaxes: K Maxwell branches beside its elastic part, a share g_k of every constant each, with a time tau_k. The
/// constants are the instantaneous ones; what is left for ever of element e is 1 - sum_k g_ek. An element of energy c x^2 / 2 in
/// its own measure x (a Hooke's spring's elongation, of another curve sqrt(2 energy), what an area or a volume has grown by) then asks c y dx of a change dx:
///   y = (1 - sum g_k) x + sum g_k s_k,   s_k' + s_k / tau_k = x':
/// springs and dashpots in its own measure, which turn with the tissue. They store c (sum g_k s_k^2) / 2 and dissipate
/// c sum g_k s_k^2 / tau_k, never less than nothing.
struct Relaxation {
    Eigen::VectorXd tau_s;          ///< ascending (K); none: the law does not relax
    NodeField share;                ///< g of each of the law's constants (E x K), sums below 1
    Eigen::VectorXd contact_share;  ///< and of what lies under the tool (K)

    bool empty() const { return tau_s.size() == 0; }
    Eigen::Index branches() const { return tau_s.size(); }
};

/// A force through such branches: (1 - sum g) F + sum Q, F straight between its times (T x D). time_s (T), ascending.
NodeField relaxed(const Eigen::VectorXd& time_s, const NodeField& force_N, const Eigen::VectorXd& tau_s, const Eigen::VectorXd& share);

/// What the law is after long: every constant times 1 - sum g, and nothing that relaxes.
LawModel long_term(const LawModel& law);

/// What the law is at once, without what relaxes.
LawModel instantaneous(const LawModel& law);

}  // namespace tissue
