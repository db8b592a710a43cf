#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "adapt/unknowns.h"
#include "mesh/free_surface.h"
#include "springs/press.h"
#include "springs/push_refusal.h"

namespace tissue {

/// One reading: where the tool touched the tissue at rest, how far it went from there, and its force on the tissue once all was still.
struct Poke {
    Point contact_m, push_m, force_N;  ///< (D)
};

struct AdaptOptions {
    std::string unknowns = "field";
    PriorOptions prior;
    double force_noise = 0.02;      ///< standard deviation of a component of a reading, over its force,
    double model_error = 0.03;      ///< of what the law is off even where it knows the tissue, likewise,
    double place_error_m = 0;       ///< and of where the contact is, along the surface
    double gate = 0.999;            ///< a reading that the model says is rarer than one in 1 / (1 - gate) is not believed
    double off_surface_m = usual_off_surface_m;  ///< a contact farther off the surface is none
    double least_push_m = 1e-4;     ///< a shorter push says nothing
    double largest = 2.5;           ///< |x| at the most: a factor of 12
    bool rival = true;              ///< beside unknowns that lie somewhere, one scale of all the tissue: the likelier of the two plays
    bool at_rest = true;            ///< of tissue that relaxes: readings are of what is left after all time; else of what it is at once
    int rounds = 2;                 ///< linearisations a poke at the most, the first at what was known before it
};

/// Throws MismatchError for a number that is out of its range.
void check(const AdaptOptions& options);

/// What became of a reading.
enum class PokeStatus {
    learned,   ///< chi2 is below the gate, and the model has it in it
    gated,     ///< chi2 is above: the model is as it was
    refused    ///< it cannot be a reading of this tissue, or the model has no answer there: `why`; the model is as it was
};
const char* to_string(PokeStatus status);

struct PokeAnswer {
    PokeStatus status = PokeStatus::refused;
    std::string why;              ///< one line; of a reading that was learned empty
    Point expected_N;             ///< before it was known (D)
    double expected_sd = 0;       ///< standard deviation of a component of that, over its size: of x, and of the law where it knows x
    double chi2 = 0, gate = 0;    ///< of the reading, and what that must stay below
    double error_before = 0;      ///< |model - reading| / |reading|,
    double error_after = 0;       ///< and to first order of the model that has learned it; 0 of one that has not
    std::string warning;          ///< of this reading and those before it together; often empty
};

/// What the model says of a push.
struct Expected {
    Point force_N;                ///< NaN unless held (D)
    Eigen::MatrixXd by_x;         ///< d force / dx over |force| (D x P)
    PressStatus status;
};

/// A law that learns from pokes, one after the other: an extended Kalman filter on Unknowns. A reading is log of the force's size and the
/// angle it has with what was expected, so that a tissue that is stiffer all over is a line and no curve:
///   r = f log(|F| / |F_model|) + angle,  H = dF_model/dx / |F_model|,  S = H P H' + R,  x += P H' S^-1 (r ...),  P -= P H' S^-1 H P
/// relinearised `rounds` times (Bell and Cathey 1993, IEEE Trans. Automatic Control 38: 294-297). Beside a field, which after few pokes takes every difference for a place's own, goes one scale of all the tissue as
/// its rival: both expect each reading, the log of how much likelier the field has made them adds up to its evidence, and until that is above
/// 0 it is the rival that plays (multiple-model estimation: Magill 1965, IEEE Trans. Automatic Control 10: 434-439). R: noise, the law's own error, and what
/// a contact that stands elsewhere would read. The same readings in the same order give the same model, to the last bit.
class Adaptation {
   public:
    /// What it holds after so many pokes; what a model.h5 keeps of it.
    struct State {
        Eigen::VectorXd x;
        Eigen::MatrixXd P;
        int learned = 0, gated = 0, refused = 0;
        int gated_in_a_row = 0;
        double scale = 0, scale_variance = 0, evidence = 0;  ///< the rival's x and its variance; log of the field's likelihood over the rival's
        std::vector<double> recent;  ///< chi2 over D of those learned last
        Poke last;                   ///< as it was read; of no size before the first
    };

    /// Throws MismatchError as make_unknowns, and check().
    Adaptation(const TissueModel& base, const AdaptOptions& options = {});

    PokeAnswer learn(const Poke& poke);

    /// The model as it is now, Van Gelder's springs beside the law too. What finite elements said of the tissue trained on it does not carry.
    TissueModel model() const;
    LawModel law() const { return with_unknowns(*base_.energy_law, unknowns_, x()); }
    /// What plays: the field, or its rival as one.
    Eigen::VectorXd x() const { return rival_plays() ? Eigen::VectorXd::Constant(unknowns_.size(), state_.scale) : state_.x; }
    bool has_rival() const { return options_.rival && unknowns_.place_m.rows() > 0; }
    bool rival_plays() const { return has_rival() && state_.evidence < 0; }

    /// What the model expects of a push, whatever it knows. Not const: it has one solver.
    /// Throws MismatchError for a push that is none of this tissue (push_refusal).
    Expected expect(const Point& contact_m, const Point& push_m);
    /// Covariance of that force over its size, D x D: of what is not known of x, of which of two rivals is right, and with_model: of the law's
    /// own error.
    Eigen::MatrixXd covariance(const Expected& expected, bool with_model = true) const;

    const TissueModel& base() const { return base_; }
    const AdaptOptions& options() const { return options_; }
    const Unknowns& unknowns() const { return unknowns_; }
    const State& state() const { return state_; }
    void restore(State state);  ///< of this model with these options. Throws MismatchError for one of another size
    void forget();              ///< as before the first poke
    /// Of a session with this object, and in no file: unknowns stay below `largest` too, and contacts are at least so unsure.
    void in_session(double largest, double place_error_m) { session_largest_ = largest, session_place_error_m_ = place_error_m; }
    double largest() const { return std::min(options_.largest, session_largest_); }                        ///< |x| at the most
    double place_error_m() const { return std::max(options_.place_error_m, session_place_error_m_); }

    const FreeSurface& surface() const { return surface_; }

   private:
    struct Linear {
        PressState rest;
        Eigen::MatrixXd by_x;  ///< dF/dx (D x P)
    };
    PressState press(const Point& contact_m, const Point& push_m, const Eigen::VectorXd& x, const PressState* from = nullptr, Linear* linear = nullptr);
    Linear linearise(const Point& contact_m, const Point& push_m, const Eigen::VectorXd& x, const PressState* from);
    Eigen::MatrixXd noise(const Poke& poke, const Point& expected_N);
    void compare(const Point& expected_N, const Poke& poke, const Eigen::MatrixXd& R, double chi2, double log_det);
    std::string refusal(const Poke& poke) const;
    std::string warning() const;

    TissueModel base_;
    AdaptOptions options_;
    Unknowns unknowns_;
    FreeSurface surface_;
    TissueEnergy energy_;
    std::unique_ptr<ContactKernel> kernel_;
    PressSolver solver_;
    double gate_, session_largest_ = std::numeric_limits<double>::infinity(), session_place_error_m_ = 0;
    State state_;
};

}  // namespace tissue
