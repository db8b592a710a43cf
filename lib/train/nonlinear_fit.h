#pragma once

#include <Eigen/Core>
#include <limits>
#include <functional>
#include <string>
#include <vector>

namespace tissue {

/// How a fit ended. g: gradient J'f of |f|^2 / 2; x: the parameters.
enum class FitStatus {
    small_gradient,   ///< max |g_i| <= gradient_tolerance |f|^2
    small_step,       ///< the last step changed no parameter by more than step_tolerance
    small_gain,       ///< the last step lowered |f|^2 by a relative change of at most gain_tolerance
    no_progress,      ///< fifteen trial steps in a row did not lower |f|, or lost a part of the function
    /// small_step or small_gain, but longer steps were rejected because they lose a part of the function
    /// (nonlinear_fit), and the Gauss-Newton step and its gain are above ten times step_tolerance and gain_tolerance
    held_back,
    iterations_done   ///< max_iterations were taken
};
const char* to_string(FitStatus status);

struct FitOptions {
    /// A contact stiffness in series with the tissue converges slowly: a fit of six parameters took 67 iterations.
    int max_iterations = 200;
    double step_tolerance = 1e-4;      ///< parameters are logarithms of stiffness: 0.01 %
    double gradient_tolerance = 1e-6;
    double gain_tolerance = 1e-5;      ///< relative change of |f|^2; of |f| it is 5e-6
    /// Largest change of a parameter in one step. A longer trial step is rejected without evaluation.
    double most_step = std::numeric_limits<double>::infinity();
};

struct FitResult {
    Eigen::VectorXd x;
    double half_square = 0;   ///< |f|^2 / 2
    double gradient = 0;      ///< max |g_i|
    int iterations = 0, evaluations = 0;
    FitStatus status = FitStatus::iterations_done;
    int lost = 0;             ///< number of parts without a value at x
};

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Fills the residuals f(x) (n) and J = df/dx (n x P). Both must be finite for every x.
using FitFunction = std::function<void(const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J)>;

/// Minimises |f(x)| from a start (P), with Levenberg-Marquardt of the GNU Scientific Library (gsl_multifit_nlinear:
/// trust region with More's scaling, modified Cholesky factor of J'J, which a ridge keeps well conditioned).
/// residuals: n, at least P.
/// lost: parts of the function (for example load cases) can be without a value at some x; the function then fills the
/// rows of such a part with bounded values and with zeros in J. It also fills *lost at every x, with 1 where a part has
/// no value. A trial step that loses a part which the current point has is rejected, as if it made |f| larger.
/// Otherwise dropping a large residual would count as progress. A step that regains a part is accepted or rejected by
/// |f|. Where such rejections stop the fit, its status is `held_back`, not converged.
/// Throws MismatchError for n < P or P < 1 and where GSL fails, and whatever the function throws.
FitResult nonlinear_fit(const FitFunction& function, int residuals, const Eigen::VectorXd& start, const FitOptions& options = {},
                        const std::vector<char>* lost = nullptr);

}  // namespace tissue
