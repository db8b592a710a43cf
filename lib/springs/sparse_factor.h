#pragma once

#include <Eigen/SparseCore>
#include <memory>

namespace tissue {

/// Factorisation of symmetric matrices with one pattern, given by their lower triangles. Large positive definite ones
/// use supernodal LL' (CHOLMOD; Chen, Davis, Hager and Rajamanickam 2008, ACM Transactions on Mathematical Software 35:
/// 22), others LDL'.
class SparseFactor {
   public:
    using Matrix = Eigen::SparseMatrix<double>;

    SparseFactor();
    ~SparseFactor();
    /// Sets the pattern of the matrices to be factorised.
    void analyse(const Matrix& pattern);
    /// False when there is a pivot of zero.
    bool factorise(const Matrix& K);
    bool is_definite() const { return definite_; }  ///< whether the last matrix was positive definite
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

   private:
    struct Factors;
    std::unique_ptr<Factors> factors_;
    bool definite_ = false;
};

}  // namespace tissue
