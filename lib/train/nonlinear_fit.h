#pragma once

#include <Eigen/Core>
#include <limits>
#include <functional>
#include <string>
#include <vector>

namespace tissue {

/// How a fit ended. g: gradient J'f of |f|^2 / 2, x: the numbers.
enum class FitStatus {
    small_gradient,   ///< max |g_i| <= gradient_tolerance |f|^2
    small_step,       ///< the last step moved no number by more than step_tolerance
    small_gain,       ///< the last step made |f|^2 smaller by less than gain_tolerance of itself
    no_progress,      ///< fifteen trial steps in a row made |f| no smaller, or lost a part that it has
    held_back,        ///< small_step or small_gain, but only because longer steps lost a part: without that bound the next Gauss-Newton step
                      ///< promised more than ten times either tolerance
    iterations_done   ///< max_iterations were taken
};
const char* to_string(FitStatus status);

struct FitOptions {
    int max_iterations = 200;          ///< a contact's stiffness in series with the tissue's is found slowly: a fit of six numbers took 67
    double step_tolerance = 1e-4;      ///< numbers are logarithms of stiffness: a hundredth of a percent
    double gradient_tolerance = 1e-6;
    double gain_tolerance = 1e-5;      ///< errors no smaller by five millionths of themselves
    double most_step = std::numeric_limits<double>::infinity();  ///< largest change of a number in a step; a longer one is rejected unasked
};

struct FitResult {
    Eigen::VectorXd x;
    double half_square = 0;   ///< |f|^2 / 2
    double gradient = 0;      ///< max |g_i|
    int iterations = 0, evaluations = 0;
    FitStatus status = FitStatus::iterations_done;
    int lost = 0;             ///< parts that have no value at x
};

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Fills f(x) (n) and J = df/dx (n x P). Must be finite everywhere.
using FitFunction = std::function<void(const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J)>;

/// Smallest |f(x)| from a start: Levenberg-Marquardt of the GNU Scientific Library (gsl_multifit_nlinear, trust region
/// with More's scaling, modified Cholesky of J'J, which a ridge keeps well conditioned). What the function throws comes
/// out here.
/// lost: where parts of the function can have no value, so that f stands for them with something bounded and J with 0: filled by the function at every
/// x, 1 where a part is lost. A trial step that loses a part which the current point has is rejected as if it made |f| larger, or losing a large error
/// would be a gain. One that finds a part again is judged by |f|. Where such rejections stop the fit it ends `held_back`, not converged.
FitResult nonlinear_fit(const FitFunction& function, int residuals, const Eigen::VectorXd& start, const FitOptions& options = {},
                        const std::vector<char>* lost = nullptr);

}  // namespace tissue
