#pragma once

#include <Eigen/Core>
#include <vector>

#include "springs/relaxation.h"

namespace tissue {

/// State of the Maxwell branches of an energy model's elements (springs/relaxation.h) for steps of constant length dt:
/// for each element its measure x at the last step, and s_k of each branch k. A step is exact where x changes linearly,
///   s_k <- e_k s_k + c_k (x - x_before),   e_k = exp(-dt / tau_k),   c_k = (1 - e_k) tau_k / dt.
/// It is passive at every dt / tau_k: with the force at the step's end the work on a branch is at least the increase of
/// its stored energy, because 0 < c_k <= 1 and 2 c_k - c_k^2 >= e_k^2 (tests/springs/test_branch_memory.cpp). Only
/// construction and book() allocate.
class BranchMemory {
   public:
    BranchMemory() = default;  ///< of an energy model that does not relax

    /// tau_s: relaxation times of the K branches [s]. share: relative moduli g of each element (n x K). dt_s: length of
    /// a step [s]. Throws MismatchError if the numbers of times and of columns of share differ; also for times or steps
    /// not above 0, negative shares, and shares whose sum is not below 1.
    BranchMemory(const Eigen::VectorXd& tau_s, const Eigen::MatrixXd& share, double dt_s);

    bool empty() const { return tau_s_.size() == 0; }
    Eigen::Index size() const { return before_.size(); }

    /// Advances the elements [first, first + n), n <= 256, by one step to the measures x (n). y (n): their generalised
    /// force per unit constant.
    void step(int first, int n, const double* x, double* y) noexcept;

    /// Sets the state of tissue that has always been at rest. The dissipated energy stays as it is.
    void forget() noexcept;

    /// From now on the dissipated energy of the branches is recorded, which makes a step slightly slower.
    void book();
    bool booked() const { return dissipated_.size() > 0; }

    /// Energy stored in an element's branches, sum g_k s_k^2 / 2, and energy dissipated in them since book(): the work
    /// of the branch forces over the steps less the increase of their stored energy. Both per unit constant.
    double branches_stored(int element) const noexcept;
    double branches_dissipated(int element) const noexcept { return booked() ? dissipated_[element] : 0; }

    /// Twice the energy that an element stores after the last step, (1 - sum g_k) x^2 + sum g_k s_k^2, per unit
    /// constant.
    double stored(int element) const noexcept;

    template <class State>
    void fields(State& state) noexcept {
        state(part_, before_, dissipated_);
    }

   private:
    Eigen::VectorXd tau_s_, decay_, risen_;  ///< tau, e, c (K)
    Eigen::MatrixXd share_, part_;           ///< g, s (n x K)
    Eigen::VectorXd left_, before_;          ///< 1 - sum g, x at the last step (n)
    Eigen::VectorXd dissipated_;                  ///< (n); empty before book()
    bool alike_ = true;                      ///< all elements have the same relative moduli
};

}  // namespace tissue
