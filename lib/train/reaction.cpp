#include "train/reaction.h"

#include "error.h"
#include "springs/equilibrium.h"
#include "train/bounded_lsq.h"
#include "train/objective.h"

namespace tissue {
namespace {

std::optional<Equilibrium> answer(const SpringMesh& mesh, const SpringLaw& law, const Reading& reading,
                                  const Eigen::VectorXd& theta, std::string& reason) {
    return solve_equilibrium(mesh, law, theta, reading.contact, reading.push_m, reason);
}

[[noreturn]] void refuse(const std::string& reason) {
    throw MismatchError("contact forces alone cannot train this spring mesh: " + reason);
}

/// Sum of squared relative errors; infinite without an equilibrium.
double misfit(const SpringMesh& mesh, const SpringLaw& law, const std::vector<Reading>& readings,
              const Eigen::VectorXd& theta) {
    double sum = 0;
    std::string reason;
    for (const Reading& r : readings) {
        const std::optional<Equilibrium> state = answer(mesh, law, r, theta, reason);
        if (!state) return std::numeric_limits<double>::infinity();
        sum += r.weight * (state->contact_force - r.force_N).squaredNorm() / r.force_N.squaredNorm();
    }
    return sum;
}

/// |r - G A theta'| of every reading, linearised at theta.
std::vector<ForceLoss> linearised(const SpringMesh& mesh, const SpringLaw& law, const std::vector<Reading>& readings,
                                  const Eigen::VectorXd& theta) {
    std::vector<ForceLoss> losses;
    std::string reason;
    for (const Reading& r : readings) {
        const std::optional<Equilibrium> state = answer(mesh, law, r, theta, reason);
        if (!state) refuse(reason);
        const std::optional<Eigen::MatrixXd> G = contact_sensitivity(mesh, law, theta, r.contact, state->displacement);
        if (!G) refuse("it has zero-energy modes");
        const Eigen::MatrixXd GA = *G * law.force_matrix(mesh, state->displacement);
        losses.emplace_back(GA.sparseView(), r.force_N, Eigen::VectorXd::Ones(r.force_N.size()));
    }
    return losses;
}

/// The linearised readings as one loss of weighted relative errors.
ForceLoss together(const std::vector<Reading>& readings, const std::vector<ForceLoss>& losses) {
    const Eigen::Index D = losses.front().target().size(), S = losses.front().matrix().cols();
    Eigen::MatrixXd rows(D * static_cast<Eigen::Index>(losses.size()), S);
    Eigen::VectorXd wanted(rows.rows());
    for (std::size_t i = 0; i < losses.size(); ++i) {
        const double unit = std::sqrt(readings[i].weight) / losses[i].scale();
        rows.middleRows(D * static_cast<Eigen::Index>(i), D) = unit * Eigen::MatrixXd(losses[i].matrix());
        wanted.segment(D * static_cast<Eigen::Index>(i), D) = unit * losses[i].target();
    }
    return {rows.sparseView(), wanted, Eigen::VectorXd::Ones(wanted.size())};
}

}  // namespace

ReactionFit fit_reactions(const SpringMesh& mesh, const SpringLaw& law, const std::vector<Reading>& readings,
                          const Eigen::VectorXd& start, const Eigen::VectorXd& theta0, double ridge, const Box& box,
                          const ReactionOptions& options) {
    const Eigen::Index S = start.size();
    SparseMatrix identity(S, S);
    identity.setIdentity();
    BoundedLsqOptions exact;
    if (ridge > 0) exact.first_shift = exact.shift;  // nothing is badly conditioned: Newton's own step at once

    std::vector<ForceLoss> losses = linearised(mesh, law, readings, start);
    ForceLoss joint = together(readings, losses);
    const double weight = ridge * joint.matrix().squaredNorm() / static_cast<double>(S), root = std::sqrt(weight);
    const auto with_pull = [&](const ForceLoss& loss) { return with_rows(loss, root * identity, root * theta0); };
    const auto objective = [&](const Eigen::VectorXd& theta) {
        return misfit(mesh, law, readings, theta) + weight * (theta - theta0).squaredNorm();
    };
    ReactionFit fit{start, losses, with_pull(joint), 0, false};
    double value = objective(fit.theta);
    while (!fit.converged && fit.iterations < options.max_iterations) {
        ++fit.iterations;
        const Eigen::VectorXd step = solve_bounded_lsq(fit.inner, fit.theta, box, exact).theta - fit.theta;
        double part = 1, next = objective(fit.theta + step);
        while (!(next < value) && part > 1e-3) {
            part /= 2;
            next = objective(fit.theta + part * step);
        }
        if (!(next < value)) {  // at rounding
            fit.converged = true;
            break;
        }
        fit.converged = value - next <= options.tolerance * value;
        fit.theta += part * step;
        value = next;
        fit.losses = linearised(mesh, law, readings, fit.theta);
        fit.inner = with_pull(together(readings, fit.losses));
    }
    return fit;
}

double best_factor(const SpringMesh& mesh, const SpringLaw& law, const std::vector<Reading>& readings,
                   const Eigen::VectorXd& theta) {
    double both = 0, own = 0;
    std::string reason;
    for (const Reading& r : readings) {
        const std::optional<Equilibrium> state = answer(mesh, law, r, theta, reason);
        if (!state) refuse(reason);
        both += state->contact_force.dot(r.force_N) / r.force_N.squaredNorm();
        own += state->contact_force.squaredNorm() / r.force_N.squaredNorm();
    }
    return both / own;
}

}  // namespace tissue
