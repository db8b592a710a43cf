#include "adapt/adaptation.h"

#include <Eigen/Dense>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "error.h"
#include "gsl.h"
#include "springs/indentation_solver.h"
#include "springs/energy_model_kernel.h"

namespace tissue {
namespace {

constexpr std::size_t window = 10;        // number of measurements whose mean chi2 is monitored
constexpr double suspicious = 3;          // mean chi2 / D with a warning: three times the value explained by noise
constexpr int another_tissue = 4;         // gated measurements in a row with a warning
// Evidence: log likelihood ratio of field over uniform scale. It starts above 0, because one measurement has no
// information on the rest of the tissue. most_of_one + least_evidence > 0: one measurement that a uniform scale cannot
// explain selects the field, however many agreed with the scale before.
constexpr double first_evidence = 1, least_evidence = -4, most_evidence = 10, most_of_one = 5;
// Step in log stiffness over which force is linear; the next step would be 0.001
constexpr double straight = 0.03;

/// Angle [rad] from one direction to another, as a vector orthogonal to the first. Zero for opposite directions.
Point turn(const Point& from, const Point& to) {
    const Point a = from.normalized(), b = to.normalized();
    const Point across = b - a.dot(b) * a;
    const double sine = across.norm();
    return sine > 0 ? Point(across * (std::atan2(sine, a.dot(b)) / sine)) : Point(Point::Zero(from.size()));
}

/// Innovation r of a measured force: log ratio of the sizes along the expected force, and angle across it (D).
Point off(const Point& expected_N, const Point& force_N) {
    return expected_N.normalized() * std::log(force_N.norm() / expected_N.norm()) + turn(expected_N, force_N);
}

/// Faster solver options: measurements have noise of per cents, so no tolerance of 1e-10 and no short load steps.
SolverOptions quick() {
    SolverOptions options;
    options.load_step = 2;
    options.tolerance = 1e-6;
    return options;
}

}  // namespace

const char* to_string(UpdateStatus status) {
    switch (status) {
        case UpdateStatus::learned:
            return "learned";
        case UpdateStatus::gated:
            return "gated";
        case UpdateStatus::refused:
            return "refused";
    }
    return "unknown";
}

void check(const AdaptOptions& o) {
    struct Range {
        const char* name;
        double value, least, most;
    };
    for (const Range& r : {Range{"relative standard deviation of the force", o.force_noise, 0, 0.5}, Range{"relative standard deviation of the model error", o.model_error, 0.001, 0.5}, Range{"standard deviation of the contact's place [m]", o.place_error_m, 0, 0.05}})
        if (!(r.value >= r.least && r.value <= r.most)) throw MismatchError(fmt::format("the {} is {:g}, must be from {:g} to {:g}", r.name, r.value, r.least, r.most));
}

Adaptation::Adaptation(const TissueModel& base, const AdaptOptions& options)
    : base_(base), options_((check(options), options)), unknowns_(make_unknowns(base_, options.unknowns, options.prior)), surface_(base_.mesh),
      energy_(base_.mesh, *base_.energy_model), kernel_(make_contact_kernel(base_.mesh, *base_.energy_model)),
      solver_(energy_, *kernel_, quick()), gate_(gsl_cdf_chisq_Pinv(options.gate, base_.mesh.dimension())) {
    forget();
}

void Adaptation::forget() {
    state_ = State();
    state_.x = Eigen::VectorXd::Zero(unknowns_.size());
    state_.P = unknowns_.prior;
    state_.evidence = first_evidence;
    state_.scale_variance = options_.prior.common * options_.prior.common + options_.prior.local * options_.prior.local;
}

void Adaptation::restore(State state) {
    if (state.x.size() != unknowns_.size() || state.P.rows() != unknowns_.size() || state.P.cols() != unknowns_.size())
        throw MismatchError(fmt::format("the adapted state has {} unknowns, unknowns '{}' of this model are {}", state.x.size(), unknowns_.kind, unknowns_.size()));
    state_ = std::move(state);
}

TissueModel Adaptation::model() const {
    TissueModel now = base_;
    now.energy_model = energy_model();
    now.contact_force_N.resize(0, now.contact_force_N.cols());  // FE forces belong to the training tissue
    // The heuristic springs are (7) with the adapted E2, so that both meshes have the stiffness of the target tissue.
    const Eigen::ArrayXd stiffer = Eigen::VectorXd(unknowns_.by_constant * x()).head(now.mesh.spring_count()).array().exp();
    now.heuristic_a.array() *= stiffer;
    now.heuristic_b.array() *= stiffer;
    return now;
}

Eigen::VectorXd Adaptation::sd() const {
    if (single_scale_in_use()) return Eigen::VectorXd::Constant(unknowns_.size(), std::sqrt(state_.scale_variance));
    return state_.P.diagonal().cwiseMax(0).cwiseSqrt();
}

Adaptation::Linear Adaptation::linearise(const Point& contact_m, const Point& push_m, const Eigen::VectorXd& x, const EquilibriumState* from) {
    Linear linear;
    indent(contact_m, push_m, x, from, &linear);
    return linear;
}

/// Equilibrium at a tool displacement with the unknowns x; into `wanted`, if given, also dF/dx. from: start state.
EquilibriumState Adaptation::indent(const Point& contact_m, const Point& push_m, const Eigen::VectorXd& x, const EquilibriumState* from, Linear* wanted) {
    EnergyModel now = with_unknowns(*base_.energy_model, unknowns_, x);
    if (options_.at_rest && !now.relaxation.empty()) now = long_term(now);
    kernel_->scale(now.contact_log_scale);
    const ContactSpring contact(kernel_->rows_at(contact_m), now.patch);
    const EquilibriumState rest = solver_.indent(now.constants, contact, push_m, from);
    if (!wanted) return rest;
    Linear& linear = *wanted;
    linear.rest = rest;
    if (rest.status == SolverStatus::no_equilibrium) return rest;
    const ForceDerivative by = solver_.force_derivative();
    linear.by_x = Eigen::MatrixXd(by.by_constant * now.constants.asDiagonal()) * unknowns_.by_constant;
    const ContactRows& rows = contact.rows;
    Eigen::RowVectorXd scale = Eigen::RowVectorXd::Zero(unknowns_.size());
    for (std::size_t i = 0; i < rows.nodes.size(); ++i) scale += rows.mean[static_cast<Eigen::Index>(i)] * unknowns_.by_node.row(rows.nodes[i]);
    for (Eigen::Index m = 0; m < by.by_parameter_row.cols(); ++m) {
        const Point force = by.by_parameter_row.col(m) * contact.parameter_value[m];
        linear.by_x += (ContactParameters::scaled(m, 2) > 1 ? 1 : -1) * force * scale;
        for (std::size_t p = 0; p < unknowns_.by_patch.size(); ++p)
            linear.by_x.col(static_cast<Eigen::Index>(p)) += force * unknowns_.by_patch[p].row(m).dot(rows.factors);
    }
    return rest;
}

Expected Adaptation::expect(const Point& contact_m, const Point& push_m) {
    if (const std::string why = push_refusal(base_.mesh, surface_, contact_m, push_m, options_.off_surface_m); !why.empty()) throw MismatchError("the indentation " + why);
    const Eigen::Index D = push_m.size();
    if (push_m.isZero(0)) return {Point::Zero(D), Eigen::MatrixXd::Zero(D, unknowns_.size()), SolverStatus::converged};
    const Linear linear = linearise(contact_m, push_m, x(), nullptr);
    const double size = linear.rest.contact_force_N.norm();
    const SolverStatus status = size > 0 ? linear.rest.status : SolverStatus::no_equilibrium;
    if (status != SolverStatus::converged) return {Point::Constant(D, std::nan("")), Eigen::MatrixXd::Zero(D, unknowns_.size()), status};
    return {linear.rest.contact_force_N, linear.by_x / size, status};
}

Eigen::MatrixXd Adaptation::covariance(const Expected& expected, bool with_model) const {
    const Eigen::Index D = expected.by_x.rows();
    Eigen::MatrixXd S = expected.by_x * state_.P * expected.by_x.transpose();
    if (has_single_scale()) {
        const double field = 1 / (1 + std::exp(-state_.evidence));
        const Point along = expected.force_N.normalized(), apart = expected.by_x * (state_.x.array() - state_.scale).matrix();
        S = field * S + (1 - field) * state_.scale_variance * along * along.transpose() + field * (1 - field) * apart * apart.transpose();
    }
    if (with_model) S += options_.model_error * options_.model_error * Eigen::MatrixXd::Identity(D, D);
    return S;
}

/// R (D x D), over the squared size of the force: noise, model error, and the change of force when the contact moves by
/// the place error along each tangent.
Eigen::MatrixXd Adaptation::noise(const ForceMeasurement& poke, const Point& expected_N) {
    const Eigen::Index D = expected_N.size();
    const double own = options_.force_noise * options_.force_noise + options_.model_error * options_.model_error;
    Eigen::MatrixXd R = own * Eigen::MatrixXd::Identity(D, D);
    const double place_error = place_error_m();
    if (!(place_error > 0)) return R;
    const FreeSurface::Place at = surface_.nearest(poke.contact_m);
    for (Eigen::Index axis = 0; axis + 1 < D; ++axis) {
        Point along = Point::Zero(D);
        if (D == 2) {
            along << -at.inward[1], at.inward[0];
        } else {
            Eigen::Index least = 0;
            at.inward.cwiseAbs().minCoeff(&least);
            const Eigen::Vector3d in = at.inward, first = in.cross(Eigen::Vector3d::Unit(least)).normalized();
            along = axis == 0 ? first : Eigen::Vector3d(in.cross(first));
        }
        Point differs = Point::Zero(D);
        int sides = 0;
        for (double side : {-1.0, 1.0}) try {
                const Linear there = linearise(at.point_m + side * place_error * along, poke.push_m, state_.x, nullptr);
                if (there.rest.status == SolverStatus::no_equilibrium) continue;
                differs += side * off(expected_N, there.rest.contact_force_N);
                ++sides;
            } catch (const MismatchError&) {  // the shifted contact is on fixed nodes
            }
        if (sides > 0) R += differs * differs.transpose() / (sides * sides);
    }
    return R;
}

/// Updates the uniform scale, whose Kalman filter is linear, and the evidence. expected_N: force predicted with the
/// scale; chi2, log_det: innovation of the field before its update.
void Adaptation::compare(const Point& expected_N, const ForceMeasurement& poke, const Eigen::MatrixXd& R, double chi2, double log_det) {
    const Point along = expected_N.normalized();
    const Eigen::MatrixXd S = state_.scale_variance * along * along.transpose() + R;
    const Eigen::LDLT<Eigen::MatrixXd> solver = S.ldlt();
    const Point r = off(expected_N, poke.force_N), gain = state_.scale_variance * solver.solve(along);
    const double own_chi2 = r.dot(solver.solve(r)), own_log_det = solver.vectorD().array().log().sum();
    const double likelier = std::clamp((own_chi2 + own_log_det - chi2 - log_det) / 2, -most_of_one, most_of_one);
    state_.evidence = std::clamp(state_.evidence + likelier, least_evidence, most_evidence);
    state_.scale = std::clamp(state_.scale + gain.dot(r), -largest(), largest());
    state_.scale_variance *= 1 - gain.dot(along);
}

std::string Adaptation::refusal(const ForceMeasurement& poke) const {
    const Eigen::Index D = base_.mesh.dimension();
    if (poke.contact_m.size() != D || poke.push_m.size() != D || poke.force_N.size() != D) return fmt::format("is not of {} axes", D);
    if (!poke.push_m.allFinite() || !poke.force_N.allFinite()) return "has a number that is not finite";
    if (std::string why = contact_refusal(base_.mesh, surface_, poke.contact_m, options_.off_surface_m); !why.empty()) return why;
    if (!(poke.push_m.norm() >= options_.least_push_m)) return fmt::format("has a tool displacement of {:.3g} mm; at least {:g} mm are needed", 1e3 * poke.push_m.norm(), 1e3 * options_.least_push_m);
    if (!(poke.force_N.norm() > 0)) return "has no force: the sensor may be disconnected";
    const FreeSurface::Place at = surface_.nearest(poke.contact_m);
    const double size_m = base_.mesh.size_m();
    if (poke.push_m.norm() > size_m / 2) return fmt::format("has a tool displacement of {:.3g} mm, more than half of the tissue's size of {:.3g} mm", 1e3 * poke.push_m.norm(), 1e3 * size_m);
    if (!(poke.push_m.dot(at.inward) > 0)) return "has a tool displacement out of the tissue or along its surface; it must point into the tissue";
    if (!(poke.force_N.dot(poke.push_m) > 0)) return "has a force against its tool displacement";
    if (state_.last.push_m.size() == D && state_.last.force_N == poke.force_N) {
        if (state_.last.contact_m == poke.contact_m && state_.last.push_m == poke.push_m) return "is identical to the measurement before it";
        return "has exactly the force of the measurement before it: the sensor may be stuck";
    }
    return "";
}

std::string Adaptation::warning() const {
    if (state_.gated_in_a_row >= another_tissue)
        return fmt::format("{} measurements in a row were gated: another tissue, or a sensor that drifts; start again with --forget", state_.gated_in_a_row);
    if (state_.recent.size() < window) return "";
    const double mean = std::accumulate(state_.recent.begin(), state_.recent.end(), 0.0) / static_cast<double>(window);
    if (mean < suspicious) return "";
    return fmt::format("the squared deviations of the last {} measurements are {:.1f} times what noise explains: the sensor may drift, or the tissue change", window, mean);
}

UpdateResult Adaptation::learn(const ForceMeasurement& poke) {
    UpdateResult answer;
    answer.gate = gate_;
    const Eigen::Index D = base_.mesh.dimension();
    answer.expected_N = Point::Zero(D);
    const auto refuse = [&](std::string why) {
        answer.why = std::move(why);
        ++state_.refused;
        return answer;
    };
    if (std::string why = refusal(poke); !why.empty()) {
        const bool read = poke.push_m.size() == D && poke.force_N.size() == D && poke.contact_m.size() == D;
        if (read) state_.last = poke;
        return refuse(std::move(why));
    }
    state_.last = poke;
    const Point at_m = surface_.nearest(poke.contact_m).point_m;
    Linear linear;
    // Force predicted with the uniform scale: the base model's force times exp(scale). Empty without equilibrium.
    Point baseline_N;
    try {
        EquilibriumState trained;
        if (has_single_scale()) trained = indent(at_m, poke.push_m, Eigen::VectorXd::Zero(unknowns_.size()));
        const bool held = has_single_scale() && trained.status == SolverStatus::converged;
        if (held) baseline_N = std::exp(state_.scale) * trained.contact_force_N;
        linear = linearise(at_m, poke.push_m, state_.x, held ? &trained : nullptr);
    } catch (const MismatchError& e) {
        return refuse(e.what());
    }
    if (linear.rest.status != SolverStatus::converged) return refuse(fmt::format("the model has no equilibrium there: {}", reason_of(status_of(linear.rest.status))));
    answer.expected_N = linear.rest.contact_force_N;

    const Point field_N = answer.expected_N;
    const Eigen::MatrixXd R = noise(poke, field_N);
    Eigen::MatrixXd H = linear.by_x / field_N.norm(), PH = state_.P * H.transpose();
    Eigen::MatrixXd S = H * PH + R;
    const Point r = off(field_N, poke.force_N);
    const Eigen::LDLT<Eigen::MatrixXd> solver = S.ldlt();
    answer.chi2 = r.dot(solver.solve(r));
    const double log_det = solver.vectorD().array().log().sum();
    if (single_scale_in_use() && baseline_N.size() > 0) answer.expected_N = baseline_N;
    answer.expected_sd = std::sqrt(covariance({answer.expected_N, H, SolverStatus::converged}).trace() / static_cast<double>(D));
    answer.error_before = (answer.expected_N - poke.force_N).norm() / poke.force_N.norm();
    if (!(answer.chi2 < gate_)) {
        ++state_.gated;
        ++state_.gated_in_a_row;
        answer.status = UpdateStatus::gated;
        answer.why = fmt::format("chi2 {:.3g} is above {:.3g}: measured {:.3g} N, expected {:.3g} N +- {:.2g} %", answer.chi2, gate_, poke.force_N.norm(),
                                 answer.expected_N.norm(), 100 * answer.expected_sd);
        answer.warning = warning();
        return answer;
    }

    // iterated update: relinearises at the new x until the step is small
    Eigen::VectorXd x = state_.x;
    Point innovation = r;
    for (int round = 1;; ++round) {
        const Eigen::VectorXd next = (state_.x + PH * S.ldlt().solve(innovation)).cwiseMax(-largest()).cwiseMin(largest());
        const double moved = (next - x).lpNorm<Eigen::Infinity>();
        answer.error_after = (innovation - H * (next - state_.x)).norm();
        if (round >= options_.rounds || moved < straight) {
            x = next;
            break;
        }
        const Linear there = linearise(at_m, poke.push_m, next, &linear.rest);
        if (there.rest.status != SolverStatus::converged) return refuse(fmt::format("the updated model has no equilibrium there: {}", reason_of(status_of(there.rest.status))));
        x = next;
        const Point& model_N = there.rest.contact_force_N;
        H = there.by_x / model_N.norm();
        PH = state_.P * H.transpose();
        S = H * PH + R;
        innovation = off(model_N, poke.force_N) + H * (x - state_.x);
    }
    if (baseline_N.size() > 0) compare(baseline_N, poke, R, answer.chi2, log_det);
    state_.x = x;
    state_.P -= PH * S.ldlt().solve(PH.transpose());
    state_.P = 0.5 * (state_.P + state_.P.transpose().eval());
    answer.status = UpdateStatus::learned;
    ++state_.learned;
    state_.gated_in_a_row = 0;
    state_.recent.push_back(answer.chi2 / static_cast<double>(D));
    if (state_.recent.size() > window) state_.recent.erase(state_.recent.begin());
    answer.warning = warning();
    return answer;
}

}  // namespace tissue
