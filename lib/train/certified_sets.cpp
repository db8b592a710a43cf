#include "train/certified_sets.h"

#include <chrono>
#include <cmath>
#include <map>

#include "parallel.h"
#include "train/certificate.h"

namespace tissue {

CertifiedSets certify(const TrainingProblems& problems, const Box& box, int threads) {
    const auto C = static_cast<Eigen::Index>(problems.minimised.size());
    CertifiedSets all{NodeField(C, box.lo.size()),
                      {Eigen::VectorXd(C), Eigen::VectorXd(C), Eigen::VectorXd(C), Eigen::VectorXd(C),
                       std::vector<std::string>(problems.minimised.size()), 0},
                      std::vector<TrainSummary>(problems.minimised.size())};
    OptimumCertificate& optimum = all.proof;
    const auto begin = std::chrono::steady_clock::now();
    parallel_for(static_cast<int>(C), threads, [&](int c) {
        const auto i = static_cast<std::size_t>(c);
        const ForceLoss& loss = problems.minimised[i];
        const BoundedLsqSummary exact = solve_bounded_lsq(loss, problems.start[i], box, problems.exact);
        all.theta.row(c) = exact.theta;
        optimum.loss_N[c] = exact.residual_norm;
        optimum.rel_loss[c] = problems.base[i].relative(exact.theta);
        optimum.lower_bound_N[c] = loss_lower_bound(loss, exact.theta, box);
        optimum.kkt_residual[c] = exact.kkt_residual;
        all.sets[i].theta = exact.theta;
        all.sets[i].loss = exact.residual_norm;
        all.sets[i].status = train_status(exact.status);
        optimum.status[i] = to_string(all.sets[i].status);
    });
    optimum.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return all;
}

SetDiagnostics gather(const std::string& optimizer, const std::vector<TrainSummary>& sets, const TrainingProblems& problems,
                    const OptimumCertificate& optimum, double seconds) {
    const auto C = static_cast<Eigen::Index>(sets.size());
    SetDiagnostics t;
    t.optimizer = optimizer;
    t.seconds = seconds;
    t.loss_N.resize(C);
    t.rel_loss.resize(C);
    t.gap.resize(C);
    std::map<int, Eigen::Index> column;  // sorted union of the iterations of all learning curves
    for (const TrainSummary& s : sets)
        for (const LearningPoint& p : s.curve) column[p.iteration] = 0;
    for (auto& [iteration, index] : column) {
        index = static_cast<Eigen::Index>(t.curve_iteration.size());
        t.curve_iteration.push_back(iteration);
    }
    t.curve_loss_N = NodeField::Constant(C, static_cast<Eigen::Index>(column.size()), std::nan(""));
    for (Eigen::Index c = 0; c < C; ++c) {
        const TrainSummary& s = sets[static_cast<std::size_t>(c)];
        const ForceLoss& base = problems.base[static_cast<std::size_t>(c)];
        t.loss_N[c] = s.loss;
        t.rel_loss[c] = base.relative(s.theta);
        t.gap[c] = loss_gap(s.loss, optimum.lower_bound_N[c], base.scale());
        t.iterations.push_back(s.iterations);
        t.evaluations.push_back(s.evaluations);
        t.restarts.push_back(s.restarts);
        t.status.push_back(to_string(s.status));
        for (const LearningPoint& p : s.curve) t.curve_loss_N(c, column[p.iteration]) = p.loss;
    }
    return t;
}

NodeField theta_of(const std::vector<TrainSummary>& sets) {
    NodeField theta(static_cast<Eigen::Index>(sets.size()), sets[0].theta.size());
    for (std::size_t c = 0; c < sets.size(); ++c) theta.row(static_cast<Eigen::Index>(c)) = sets[c].theta;
    return theta;
}

}  // namespace tissue
