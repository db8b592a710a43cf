#pragma once

#include <Eigen/SparseCore>
#include <memory>

namespace tissue {

/// Factors of symmetric matrices of one pattern, of which the lower triangle is given: supernodal LL' (CHOLMOD; Chen, Davis, Hager and Rajamanickam 2008, ACM
/// Transactions on Mathematical Software 35: 22) where they are large and positive definite, else LDL'.
class SparseFactor {
   public:
    using Matrix = Eigen::SparseMatrix<double>;

    SparseFactor();
    ~SparseFactor();
    /// Of the matrices that come: their pattern.
    void analyse(const Matrix& pattern);
    /// False when it has a pivot of zero.
    bool factorise(const Matrix& K);
    bool is_definite() const { return definite_; }  ///< positive, of the last one
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

   private:
    struct Factors;
    std::unique_ptr<Factors> factors_;
    bool definite_ = false;
};

}  // namespace tissue
