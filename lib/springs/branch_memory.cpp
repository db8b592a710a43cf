#include "springs/branch_memory.h"

#include <fmt/format.h>

#include <cmath>

#include "error.h"
#include "hot_loop.h"

namespace tissue {
namespace kernel {

/// dx = x - before, before = x, y = left x.
TISSUE_HOT void begin(int n, const double* __restrict left, const double* __restrict x, double* __restrict before, double* __restrict dx,
                      double* __restrict y) {
    for (int i = 0; i < n; ++i) {
        dx[i] = x[i] - before[i];
        before[i] = x[i];
        y[i] = left[i] * x[i];
    }
}

TISSUE_HOT void branch(int n, double e, double c, const double* __restrict g, const double* __restrict dx, double* __restrict s, double* __restrict y) {
    for (int i = 0; i < n; ++i) {
        s[i] = e * s[i] + c * dx[i];
        y[i] += g[i] * s[i];
    }
}

/// As branch(), and dissipated += g (s dx - increase of s^2 / 2).
TISSUE_HOT void branch_booked(int n, double e, double c, const double* __restrict g, const double* __restrict dx, double* __restrict s, double* __restrict y,
                              double* __restrict dissipated) {
    for (int i = 0; i < n; ++i) {
        const double now = e * s[i] + c * dx[i];
        dissipated[i] += g[i] * (now * dx[i] - (now - s[i]) * (now + s[i]) / 2);
        s[i] = now;
        y[i] += g[i] * now;
    }
}

/// As branch(), for elements with the same relative modulus g.
TISSUE_HOT void branch_alike(int n, double e, double c, double g, const double* __restrict dx, double* __restrict s, double* __restrict y) {
    for (int i = 0; i < n; ++i) {
        s[i] = e * s[i] + c * dx[i];
        y[i] += g * s[i];
    }
}

/// begin() and branch_alike() in one loop for three branches, the usual number.
TISSUE_HOT void three_alike(int n, double left, const double* e, const double* c, const double* g, const double* __restrict x, double* __restrict before,
                            double* __restrict s0, double* __restrict s1, double* __restrict s2, double* __restrict y) {
    const double e0 = e[0], e1 = e[1], e2 = e[2], c0 = c[0], c1 = c[1], c2 = c[2], g0 = g[0], g1 = g[1], g2 = g[2];
    for (int i = 0; i < n; ++i) {
        const double dx = x[i] - before[i];
        before[i] = x[i];
        const double t0 = e0 * s0[i] + c0 * dx, t1 = e1 * s1[i] + c1 * dx, t2 = e2 * s2[i] + c2 * dx;
        s0[i] = t0;
        s1[i] = t1;
        s2[i] = t2;
        y[i] = left * x[i] + g0 * t0 + g1 * t1 + g2 * t2;
    }
}

}  // namespace kernel

namespace {

constexpr int chunk = 256;

}  // namespace

BranchMemory::BranchMemory(const Eigen::VectorXd& tau_s, const Eigen::MatrixXd& share, double dt_s)
    : tau_s_(tau_s), decay_((-dt_s * tau_s.cwiseInverse()).array().exp()), risen_(tau_s.size()), share_(share),
      part_(Eigen::MatrixXd::Zero(share.rows(), share.cols())), left_(1 - share.rowwise().sum().array()), before_(Eigen::VectorXd::Zero(share.rows())) {
    if (share.cols() != tau_s.size() || !(dt_s > 0)) throw MismatchError(fmt::format("relative moduli of {} Maxwell branches for {} relaxation times", share.cols(), tau_s.size()));
    if (share.size() > 0 && (!(tau_s.minCoeff() > 0) || !(share.minCoeff() >= 0) || !(left_.minCoeff() > 0)))
        throw MismatchError("Maxwell branches need relaxation times > 0 and relative moduli >= 0 whose sum is below 1");
    for (Eigen::Index k = 0; k < tau_s.size(); ++k) risen_[k] = -std::expm1(-dt_s / tau_s[k]) * tau_s[k] / dt_s;
    for (Eigen::Index i = 0; i < share.rows() && alike_; ++i) alike_ = share.row(i) == share.row(0);
}

void BranchMemory::step(int first, int n, const double* x, double* y) noexcept {
    const Eigen::Index K = tau_s_.size(), N = before_.size();
    double *before = before_.data() + first, *s = part_.data() + first;
    if (alike_ && K == 3 && !booked()) {
        const double g[3] = {share_(0, 0), share_(0, 1), share_(0, 2)};
        kernel::three_alike(n, left_[0], decay_.data(), risen_.data(), g, x, before, s, s + N, s + 2 * N, y);
        return;
    }
    alignas(64) double dx[chunk];
    kernel::begin(n, left_.data() + first, x, before, dx, y);
    for (Eigen::Index k = 0; k < K; ++k, s += N) {
        if (booked())
            kernel::branch_booked(n, decay_[k], risen_[k], share_.data() + k * N + first, dx, s, y, dissipated_.data() + first);
        else if (alike_)
            kernel::branch_alike(n, decay_[k], risen_[k], share_(0, k), dx, s, y);
        else
            kernel::branch(n, decay_[k], risen_[k], share_.data() + k * N + first, dx, s, y);
    }
}

void BranchMemory::forget() noexcept {
    part_.setZero();
    before_.setZero();
}

void BranchMemory::book() {
    if (!booked()) dissipated_ = Eigen::VectorXd::Zero(before_.size());
}

double BranchMemory::branches_stored(int element) const noexcept {
    double twice = 0;
    for (Eigen::Index k = 0; k < tau_s_.size(); ++k) twice += share_(element, k) * part_(element, k) * part_(element, k);
    return twice / 2;
}

double BranchMemory::stored(int element) const noexcept {
    return left_[element] * before_[element] * before_[element] + 2 * branches_stored(element);
}

}  // namespace tissue
