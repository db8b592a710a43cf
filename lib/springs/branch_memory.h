#pragma once

#include <Eigen/Core>
#include <vector>

#include "springs/relaxation.h"

namespace tissue {

/// What the elements of a law remember while it moves in steps of one length (Relaxation): of each element its measure x a step ago and
/// of each branch s_k. A step is exact where x goes straight,
///   s_k <- e_k s_k + c_k (x - x_before),   e_k = exp(-dt / tau_k),   c_k = (1 - e_k) tau_k / dt,
/// and passive at every dt / tau: with the pull at its end the work on a branch is never less than what it stores, since
/// c_k >= 1/2 ... 1 and 2 c_k - c_k^2 >= e_k^2 (tests/springs/test_branch_memory.cpp). Made once; nothing else allocates.
class BranchMemory {
   public:
    BranchMemory() = default;  ///< of a law that does not relax

    /// share: g of each element (n x K).
    BranchMemory(const Eigen::VectorXd& tau_s, const Eigen::MatrixXd& share, double dt_s);

    bool empty() const { return tau_s_.size() == 0; }
    Eigen::Index size() const { return before_.size(); }

    /// A step of the elements [first, first + n), n <= 256, to the measures x; y: what they pull with, by unit constant. Both (n).
    void step(int first, int n, const double* x, double* y) noexcept;

    /// At rest from all time.
    void forget() noexcept;

    /// From now on the branches' own energy is booked; a step takes a little longer.
    void book();
    bool booked() const { return dissipated_.size() > 0; }

    /// What an element's branches store, sum g_k s_k^2 / 2, and what they have dissipated since book(), forget() or not: the work of their
    /// pulls over the steps less what they came to store. By unit constant.
    double branches_stored(int element) const noexcept;
    double branches_dissipated(int element) const noexcept { return booked() ? dissipated_[element] : 0; }

    /// (1 - sum g_k) x^2 + sum g_k s_k^2 of an element, as the last step left it: twice what it stores, by unit constant.
    double stored(int element) const noexcept;

    template <class State>
    void fields(State& state) noexcept {
        state(part_, before_, dissipated_);
    }

   private:
    Eigen::VectorXd tau_s_, decay_, risen_;  ///< e, c (K)
    Eigen::MatrixXd share_, part_;           ///< g, s (n x K)
    Eigen::VectorXd left_, before_;          ///< 1 - sum g, x a step ago (n)
    Eigen::VectorXd dissipated_;                  ///< (n), empty where nothing is booked
    bool alike_ = true;                      ///< all elements have the first one's shares
};

}  // namespace tissue
