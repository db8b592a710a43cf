#include "train/reaction.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "error.h"
#include "springs/equilibrium.h"
#include "train/bounded_lsq.h"
#include "train/loss_terms.h"

namespace tissue {
namespace {

[[noreturn]] void refuse(const std::string& reason) {
    throw MismatchError("contact forces alone cannot train this spring mesh: " + reason);
}

/// What a residual [N] is multiplied by to count in the objective: root of the weight over the force [1/N].
double unit_of(const Reading& reading) {
    const double force = reading.force_N.norm();
    return force > 0 ? std::sqrt(reading.weight) / force : 0;
}

/// The closed loop's answers at theta, and G A there: what a change of theta makes of them, to first order.
struct Answers {
    double misfit = std::numeric_limits<double>::infinity();  ///< weighted sum of squared relative errors
    std::vector<Eigen::VectorXd> force_N;
    std::vector<Eigen::MatrixXd> GA;                          ///< of each reading (D x S)
    std::string reason;                                       ///< why there are none
};

Answers answers(const SpringMesh& mesh, const SpringLaw& law, const std::vector<Reading>& readings,
                const Eigen::VectorXd& theta) {
    std::vector<SurfacePoint> contacts;
    std::vector<Eigen::VectorXd> pushes;
    for (const Reading& r : readings) {
        contacts.push_back(r.contact);
        pushes.push_back(r.push_m);
    }
    Answers a;
    EquilibriumStatus status{};
    const auto responses = contact_responses(mesh, law, theta, contacts, pushes, status);
    a.reason = reason_of(status);
    if (!responses) return a;
    a.misfit = 0;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const ContactResponse& response = (*responses)[i];
        const Eigen::VectorXd& wanted = readings[i].force_N;
        a.force_N.push_back(response.state.contact_force);
        if (wanted.squaredNorm() > 0)
            a.misfit += readings[i].weight * (a.force_N.back() - wanted).squaredNorm() / wanted.squaredNorm();
        a.GA.push_back(response.sensitivity * law.force_matrix(mesh, response.state.displacement));
    }
    return a;
}

/// min |b - M theta|^2 + weight |theta - theta0|^2 over the box: M has few rows, one a component of a reading.
struct Step {
    Eigen::MatrixXd M;
    Eigen::VectorXd b;
    double weight;

    Step(const std::vector<Reading>& readings, const Answers& a) : weight(0) {
        const Eigen::Index D = readings.front().force_N.size();
        M.resize(D * static_cast<Eigen::Index>(readings.size()), a.GA.front().cols());
        b.resize(M.rows());
        for (std::size_t i = 0; i < readings.size(); ++i) {
            const double unit = unit_of(readings[i]);
            M.middleRows(D * static_cast<Eigen::Index>(i), D) = unit * a.GA[i];
            b.segment(D * static_cast<Eigen::Index>(i), D) = unit * readings[i].force_N;
        }
    }

    double value(const Eigen::VectorXd& theta, const Eigen::VectorXd& theta0) const {
        return (b - M * theta).squaredNorm() + weight * (theta - theta0).squaredNorm();
    }

    /// `factor` times its root, as a loss.
    ForceLoss loss(const Eigen::VectorXd& theta0, double factor = 1) const {
        SparseMatrix identity(theta0.size(), theta0.size());
        identity.setIdentity();
        const double root = factor * std::sqrt(weight);
        return with_rows({(factor * M).sparseView(), factor * b, Eigen::VectorXd::Ones(b.size())}, root * identity,
                         root * theta0);
    }
};

/// The step's solution. With a ridge the springs that the box does not hold follow from a system as small as M has rows;
/// which those are is found by trying: too far ones are held, held ones that are drawn inside let go. Few tries settle
/// it; where they do not, and without a ridge, bounded_lsq does. Only a direction to go in: how far it is worth going, and
/// whether the fit is at its end, the objective says.
Eigen::VectorXd solve(const Step& s, const Eigen::VectorXd& start, const Eigen::VectorXd& theta0, const Box& box) {
    constexpr int tries = 30;
    std::vector<int> held(static_cast<std::size_t>(start.size()), 0);  // -1 at lo, 1 at hi
    for (int t = 0; s.weight > 0 && t < tries; ++t) {
        Eigen::MatrixXd inactive = s.M;  // columns of the springs whose bounds are inactive
        Eigen::VectorXd theta = theta0;
        for (Eigen::Index k = 0; k < theta.size(); ++k)
            if (const int side = held[static_cast<std::size_t>(k)]) {
                theta[k] = side < 0 ? box.lo[k] : box.hi[k];
                inactive.col(k).setZero();
            }
        Eigen::MatrixXd system = inactive * inactive.transpose();
        system.diagonal().array() += s.weight;
        theta += inactive.transpose() * system.ldlt().solve(s.b - s.M * theta);
        const Eigen::VectorXd slope = s.weight * (theta - theta0) - s.M.transpose() * (s.b - s.M * theta);
        bool settled = true;
        for (Eigen::Index k = 0; k < theta.size(); ++k) {
            int& side = held[static_cast<std::size_t>(k)];
            const int now = side == 0   ? (theta[k] < box.lo[k] ? -1 : theta[k] > box.hi[k] ? 1 : 0)
                            : side < 0 ? (slope[k] >= 0 ? -1 : 0)
                                       : (slope[k] <= 0 ? 1 : 0);
            settled &= now == side;
            side = now;
        }
        if (settled) return theta;
    }
    return solve_bounded_lsq(s.loss(theta0), start, box).theta;
}

}  // namespace

ReactionFit fit_reactions(const SpringMesh& mesh, const SpringLaw& law, const std::vector<Reading>& readings,
                          const Eigen::VectorXd& start, const Eigen::VectorXd& theta0, double ridge, const Box& box,
                          const ReactionOptions& options) {
    Answers now = answers(mesh, law, readings, start);
    if (!now.reason.empty()) refuse(now.reason);
    Step step(readings, now);
    const double weight = ridge * step.M.squaredNorm() / static_cast<double>(start.size());
    const auto pull = [&](const Eigen::VectorXd& theta) { return weight * (theta - theta0).squaredNorm(); };
    Eigen::VectorXd theta = start;
    double value = now.misfit + pull(theta);
    int iterations = 0;
    ReactionStatus status = ReactionStatus::iterations_done;
    while (status == ReactionStatus::iterations_done && iterations < options.max_iterations) {
        ++iterations;
        step.weight = weight;
        const Eigen::VectorXd aim = solve(step, theta, theta0, box), change = aim - theta;
        // theta plus a part of what leads to a side of the box may end a rounding beyond it
        const auto moved = [&](double part) { return box.project(theta + part * change); };
        double part = 1;
        Eigen::VectorXd to = moved(part);
        Answers next = answers(mesh, law, readings, to);
        while (!(next.misfit + pull(to) < value) && part > 1e-3) {
            part /= 2;
            to = moved(part);
            next = answers(mesh, law, readings, to);
        }
        const double fell = value - next.misfit - pull(to);
        if (!(fell > 0)) {
            const double promised = value - step.value(aim, theta0);
            status = promised > options.tolerance * value ? ReactionStatus::stalled : ReactionStatus::converged;
            break;
        }
        if (fell <= options.tolerance * value) status = ReactionStatus::converged;
        theta = to;
        value -= fell;
        now = std::move(next);
        step = Step(readings, now);
    }
    step.weight = weight;
    std::vector<ForceLoss> losses;
    for (std::size_t i = 0; i < readings.size(); ++i)
        losses.emplace_back(now.GA[i].sparseView(), readings[i].force_N, Eigen::VectorXd::Ones(readings[i].force_N.size()));
    const double force = readings.front().force_N.norm();
    return {theta, losses, step.loss(theta0, force > 0 ? force : 1), iterations, status};
}

double best_factor(const SpringMesh& mesh, const SpringLaw& law, const std::vector<Reading>& readings,
                   const Eigen::VectorXd& theta) {
    const Answers a = answers(mesh, law, readings, theta);
    if (!a.reason.empty()) refuse(a.reason);
    double both = 0, own = 0;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const double unit = readings[i].force_N.squaredNorm();
        if (!(unit > 0)) continue;
        both += a.force_N[i].dot(readings[i].force_N) / unit;
        own += a.force_N[i].squaredNorm() / unit;
    }
    if (!(own > 0)) refuse("no reading has a force");
    return both / own;
}

}  // namespace tissue
