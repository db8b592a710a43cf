#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "adapt/unknowns.h"
#include "mesh/free_surface.h"
#include "springs/equilibrium_solver.h"
#include "springs/push_refusal.h"

namespace tissue {

/// One measurement on the target tissue: contact at rest [m], tool displacement from there [m], and force of the tool
/// on the tissue at rest [N].
struct ForceMeasurement {
    Point contact_m, push_m, force_N;  ///< (D)
};

struct AdaptOptions {
    std::string unknowns = "field"; ///< kind of the unknowns (make_unknowns)
    PriorOptions prior;
    double force_noise = 0.02;      ///< standard deviation of a force component, over the force
    double model_error = 0.03;      ///< model error: standard deviation of a force component, over the force
    double place_error_m = 0;       ///< standard deviation of the contact's place along the surface
    /// A measurement is gated unless its chi2 is below this quantile of the chi-squared distribution with D degrees of
    /// freedom. Default: one valid measurement in a thousand is gated.
    double gate = 0.999;
    double off_surface_m = usual_off_surface_m;  ///< largest distance of a contact from the free surface
    double least_push_m = 1e-4;     ///< smallest tool displacement of a measurement
    double largest = 2.5;           ///< bound of |x|: a factor of 12 in stiffness
    /// Also estimate one uniform scale of the stiffness, as an alternative to the kinds `field` and `elements`; the
    /// more probable of the two is used.
    bool rival = true;
    bool at_rest = true;            ///< tissue that relaxes: measurements are long-term forces; else instantaneous ones
    int rounds = 2;                 ///< most linearisations for a measurement; the first is at the prior estimate
};

/// Throws MismatchError unless force_noise is in 0 .. 0.5, model_error in 0.001 .. 0.5 and place_error_m in 0 .. 0.05.
void check(const AdaptOptions& options);

/// Outcome of a measurement.
enum class UpdateStatus {
    learned,   ///< chi2 is below the gate; the model is updated
    gated,     ///< chi2 is not below the gate; the model is unchanged
    /// Not a valid measurement of this tissue, or no equilibrium of the model (`why`); the model is unchanged.
    refused
};
const char* to_string(UpdateStatus status);

struct UpdateResult {
    UpdateStatus status = UpdateStatus::refused;
    std::string why;              ///< cause of `gated` or `refused`, one line; else empty
    Point expected_N;             ///< predicted force before the update (D)
    /// Standard deviation of a component of it over its size: of x and of the model error.
    double expected_sd = 0;
    double chi2 = 0, gate = 0;    ///< squared normalised innovation, and its limit
    double error_before = 0;      ///< |predicted - measured| / |measured| before the update
    double error_after = 0;       ///< the same after the update, to first order; 0 without an update
    std::string warning;          ///< on this and earlier measurements together; often empty
};

/// Predicted force at a tool displacement.
struct Expected {
    Point force_N;                ///< (D); NaN unless status is `converged`
    Eigen::MatrixXd by_x;         ///< d force / dx over |force| (D x P)
    SolverStatus status;
};

/// Adapts an energy model to measurements on a target tissue, one by one: an extended Kalman filter for the state x of
/// Unknowns. The innovation r has the logarithm of the force ratio along the predicted direction f, and the angle
/// between measured and predicted force across it. The logarithm makes r linear in a uniform change of log stiffness.
///   r = f log(|F| / |F_model|) + angle,  H = dF_model/dx / |F_model|,  S = H P H' + R,
///   x <- x_prior + P H' S^-1 (r + H (x - x_prior)),  P <- P - P H' S^-1 H P
/// The update is iterated with at most `rounds` linearisations (Bell and Cathey 1993, IEEE Trans. Automatic Control 38:
/// 294-297). R is the covariance of noise, model error and the error of the contact's place.
///
/// Uniform scale (`rival`): a field explains few measurements by local differences only. A second filter therefore
/// estimates one scale for the whole tissue. The logarithm of the likelihood ratio of field and scale is summed over
/// the measurements (`evidence`, 1 at the start). The scale is used while it is below 0, else the field (multiple-model
/// estimation: Magill 1965, IEEE Trans. Automatic Control 10: 434-439).
/// The same measurements in the same order give the same model, bit for bit.
class Adaptation {
   public:
    /// State after the measurements so far; stored in model.h5.
    struct State {
        Eigen::VectorXd x;                        ///< (P)
        Eigen::MatrixXd P;                        ///< covariance of x (P x P)
        int learned = 0, gated = 0, refused = 0;  ///< numbers of measurements
        int gated_in_a_row = 0;
        /// Uniform scale: log stiffness and its variance; logarithm of the likelihood ratio field / scale.
        double scale = 0, scale_variance = 0, evidence = 0;
        std::vector<double> recent;  ///< chi2 / D of the last ten learned measurements
        ForceMeasurement last;                   ///< last measurement, learned or not; empty vectors before the first
    };

    /// base: model before the first measurement. Throws MismatchError as make_unknowns and check().
    Adaptation(const TissueModel& base, const AdaptOptions& options = {});

    /// Updates the model with one measurement, or gates or refuses it.
    UpdateResult learn(const ForceMeasurement& poke);

    /// The adapted model, with Van Gelder's springs adapted too. It has no FE contact forces, which belong to the
    /// training tissue.
    TissueModel model() const;
    EnergyModel energy_model() const { return with_unknowns(*base_.energy_model, unknowns_, x()); }
    /// Unknowns in use (P): the field, or the uniform scale in every entry.
    Eigen::VectorXd x() const { return single_scale_in_use() ? Eigen::VectorXd::Constant(unknowns_.size(), state_.scale) : state_.x; }
    Eigen::VectorXd sd() const;  ///< posterior standard deviations of x() (P)
    bool has_single_scale() const { return options_.rival && unknowns_.place_m.rows() > 0; }
    bool single_scale_in_use() const { return has_single_scale() && state_.evidence < 0; }

    /// Predicted force at a contact [m] (D) with a tool displacement [m] (D). Not const: the solver has a state.
    /// Throws MismatchError for an invalid contact or displacement (push_refusal).
    Expected expect(const Point& contact_m, const Point& push_m);
    /// Covariance (D x D) of that force over its size: from the covariance of x, from the choice between field and
    /// uniform scale, and, with_model, from the model error.
    Eigen::MatrixXd covariance(const Expected& expected, bool with_model = true) const;

    const TissueModel& base() const { return base_; }
    const AdaptOptions& options() const { return options_; }
    const Unknowns& unknowns() const { return unknowns_; }
    const State& state() const { return state_; }
    void restore(State state);  ///< a state of the same model and options. Throws MismatchError for another size
    void forget();              ///< resets to the state before the first measurement
    /// Limits of a session, not stored in a file: a further bound of |x|, and a lower bound of place_error_m.
    void in_session(double largest, double place_error_m) { session_largest_ = largest, session_place_error_m_ = place_error_m; }
    /// Bound of |x|.
    double largest() const { return std::min(options_.largest, session_largest_); }
    double place_error_m() const { return std::max(options_.place_error_m, session_place_error_m_); }

    const FreeSurface& surface() const { return surface_; }

   private:
    struct Linear {
        EquilibriumState rest;
        Eigen::MatrixXd by_x;  ///< dF/dx (D x P)
    };
    EquilibriumState indent(const Point& contact_m, const Point& push_m, const Eigen::VectorXd& x, const EquilibriumState* from = nullptr, Linear* linear = nullptr);
    Linear linearise(const Point& contact_m, const Point& push_m, const Eigen::VectorXd& x, const EquilibriumState* from);
    Eigen::MatrixXd noise(const ForceMeasurement& poke, const Point& expected_N);
    void compare(const Point& expected_N, const ForceMeasurement& poke, const Eigen::MatrixXd& R, double chi2, double log_det);
    std::string refusal(const ForceMeasurement& poke) const;
    std::string warning() const;

    TissueModel base_;
    AdaptOptions options_;
    Unknowns unknowns_;
    FreeSurface surface_;
    TissueEnergy energy_;
    std::unique_ptr<ContactKernel> kernel_;
    EquilibriumSolver solver_;
    double gate_, session_largest_ = std::numeric_limits<double>::infinity(), session_place_error_m_ = 0;
    State state_;
};

}  // namespace tissue
