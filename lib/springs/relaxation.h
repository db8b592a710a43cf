#pragma once

#include <Eigen/Core>

#include "field.h"

namespace tissue {

struct EnergyModel;

/// Relaxation of an energy model: K Maxwell branches in parallel to its elastic part. Branch k has the relative modulus
/// g_k of every constant and the relaxation time tau_k. The constants of the model are the instantaneous ones. In the
/// long term element e keeps 1 - sum_k g_ek of its constant. An element has the energy c x^2 / 2 in its own measure x:
/// the elongation of a Hooke's spring, sqrt(2 energy / c) of a spring with another curve, the growth of an area or
/// volume. A change dx then takes the work c y dx, with
///   y = (1 - sum g_k) x + sum g_k s_k,   s_k' + s_k / tau_k = x'.
/// The branches thus act in the element's own measure and rotate with the tissue. They store c (sum g_k s_k^2) / 2 and
/// dissipate c sum g_k s_k^2 / tau_k >= 0.
struct Relaxation {
    Eigen::VectorXd tau_s;          ///< tau_k, ascending (K); empty: no relaxation
    NodeField share;                ///< g of each constant of the model (E x K), sums below 1
    Eigen::VectorXd contact_share;  ///< g of the contact (K)

    bool empty() const { return tau_s.size() == 0; }
    Eigen::Index branches() const { return tau_s.size(); }
};

/// Relaxed force of an elastic force history force_N (T x D), linear between the times time_s (T), ascending: (1 - sum
/// g) F + sum Q. tau_s, share (K): relaxation times and relative moduli.
NodeField relaxed(const Eigen::VectorXd& time_s, const NodeField& force_N, const Eigen::VectorXd& tau_s, const Eigen::VectorXd& share);

/// Energy model of the long-term response: every constant times 1 - sum g, without relaxation.
EnergyModel long_term(const EnergyModel& energy_model);

/// Energy model of the instantaneous response, without relaxation.
EnergyModel instantaneous(const EnergyModel& energy_model);

}  // namespace tissue
