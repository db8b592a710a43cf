#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

namespace tissue {

/// How a fit ended. g: gradient J'f of |f|^2 / 2, x: the numbers.
enum class FitStatus {
    small_gradient,   ///< max |g_i| <= gradient_tolerance |f|^2
    small_step,       ///< the last step moved no number by more than step_tolerance
    small_gain,       ///< the last step made |f|^2 smaller by less than gain_tolerance of itself
    no_progress,      ///< fifteen trial steps in a row made |f| no smaller
    iterations_done   ///< max_iterations were taken
};
const char* to_string(FitStatus status);

struct FitOptions {
    int max_iterations = 60;
    double step_tolerance = 1e-4;      ///< numbers are logarithms of stiffness: a hundredth of a percent
    double gradient_tolerance = 1e-6;
    double gain_tolerance = 1e-5;      ///< errors no smaller by five millionths of themselves
};

struct FitResult {
    Eigen::VectorXd x;
    double half_square = 0;   ///< |f|^2 / 2
    double gradient = 0;      ///< max |g_i|
    int iterations = 0, evaluations = 0;
    FitStatus status = FitStatus::iterations_done;
};

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Fills f(x) (n) and J = df/dx (n x P). Must be finite everywhere.
using FitFunction = std::function<void(const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J)>;

/// Smallest |f(x)| from a start: Levenberg-Marquardt of the GNU Scientific Library (gsl_multifit_nlinear, trust region
/// with More's scaling, modified Cholesky of J'J, which a ridge keeps well conditioned). What the function throws comes
/// out here.
FitResult nonlinear_fit(const FitFunction& function, int residuals, const Eigen::VectorXd& start, const FitOptions& options = {});

}  // namespace tissue
