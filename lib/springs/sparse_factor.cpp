#include "springs/sparse_factor.h"

#include <Eigen/CholmodSupport>
#include <Eigen/SparseCholesky>

namespace tissue {
namespace {

constexpr Eigen::Index few = 1500;  // up to so many unknowns LDL' is as fast

}  // namespace

struct SparseFactor::Factors {
    Eigen::CholmodSupernodalLLT<Matrix> llt;
    Eigen::SimplicialLDLT<Matrix> ldlt;
    bool supernodal = false, ldlt_analysed = false;
};

SparseFactor::SparseFactor() : factors_(std::make_unique<Factors>()) {
    // otherwise CHOLMOD reports indefinite matrices on standard output
    factors_->llt.cholmod().print = 0;
}

SparseFactor::~SparseFactor() = default;

void SparseFactor::analyse(const Matrix& pattern) {
    factors_->supernodal = pattern.rows() > few;
    if (factors_->supernodal) factors_->llt.analyzePattern(pattern);
    factors_->ldlt_analysed = false;
}

bool SparseFactor::factorise(const Matrix& K) {
    if (factors_->supernodal) {
        factors_->llt.factorize(K);
        definite_ = factors_->llt.info() == Eigen::Success;
        if (definite_) return true;
    }
    if (!factors_->ldlt_analysed) factors_->ldlt.analyzePattern(K);
    factors_->ldlt_analysed = true;
    factors_->ldlt.factorize(K);
    const bool regular = factors_->ldlt.info() == Eigen::Success;
    definite_ = regular && factors_->ldlt.vectorD().minCoeff() > 0;
    return regular;
}

Eigen::MatrixXd SparseFactor::solve(const Eigen::MatrixXd& right) const {
    if (definite_ && factors_->supernodal) return factors_->llt.solve(right);
    return factors_->ldlt.solve(right);
}

}  // namespace tissue
