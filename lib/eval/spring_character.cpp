#include "eval/spring_character.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "eval/force_error.h"
#include "springs/spring_law.h"
#include "train/bounded_lsq.h"

namespace tissue {
namespace {

double rms(const Eigen::VectorXd& v) {
    return v.size() == 0 ? std::nan("") : v.norm() / std::sqrt(static_cast<double>(v.size()));
}

/// Eigenvalues of K at rest without the rows and columns of fixed nodes, ascending.
Eigen::VectorXd supported_eigenvalues(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta) {
    const int D = mesh.dimension();
    const Eigen::MatrixXd K(law.stiffness(mesh, theta, NodeField::Zero(mesh.node_count(), D)));
    std::vector<bool> is_fixed(static_cast<std::size_t>(mesh.node_count()), false);
    for (int node : mesh.fixed) is_fixed[static_cast<std::size_t>(node)] = true;
    std::vector<int> free;
    for (int i = 0; i < D * mesh.node_count(); ++i)
        if (!is_fixed[static_cast<std::size_t>(i / D)]) free.push_back(i);
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K(free, free), Eigen::EigenvaluesOnly).eigenvalues();
}

/// For each spring, whether it has an end among the 3 x 3 nodes about a contact.
std::vector<bool> near_springs(const SpringMesh& mesh, const Eigen::Vector2d& contact) {
    // spacing of the lattice along each axis: the shortest span of a spring
    Eigen::Vector2d reach = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    for (int s = 0; s < mesh.spring_count(); ++s)
        for (int d : {0, 1}) {
            const double step = std::abs(mesh.nodes(mesh.springs(s, 0), d) - mesh.nodes(mesh.springs(s, 1), d));
            if (step > 0) reach[d] = std::min(reach[d], 1.01 * step);
        }
    std::vector<bool> near(static_cast<std::size_t>(mesh.spring_count()), false);
    for (int s = 0; s < mesh.spring_count(); ++s)
        for (int end : {0, 1})
            if (((mesh.nodes.row(mesh.springs(s, end)).transpose() - contact).cwiseAbs().array() <= reach.array()).all())
                near[static_cast<std::size_t>(s)] = true;
    return near;
}

/// L^2 + ridge |theta - theta0|^2 as a force loss, with one more row for each spring.
ForceLoss with_ridge(const SparseMatrix& A, const Eigen::VectorXd& force, const Eigen::VectorXd& weight, double ridge,
                     const Eigen::VectorXd& theta0) {
    const Eigen::Index rows = A.rows(), S = A.cols();
    std::vector<Eigen::Triplet<double>> entries;
    for (int c = 0; c < A.outerSize(); ++c) {
        for (SparseMatrix::InnerIterator it(A, c); it; ++it) entries.emplace_back(it.row(), c, it.value());
        entries.emplace_back(rows + c, c, 1.0);
    }
    SparseMatrix extended(rows + S, S);
    extended.setFromTriplets(entries.begin(), entries.end());
    Eigen::VectorXd f(rows + S), w(rows + S);
    f << force, theta0;
    w << weight, Eigen::VectorXd::Constant(S, ridge);
    return {extended, f, w};
}

}  // namespace

SpringCharacter spring_character(const TissueModel& model, const Cases& cases, const NodeField& theta) {
    const std::unique_ptr<SpringLaw> law = make_spring_law(model.law);
    const std::vector<LoadCase> loads = load_cases(cases);
    const auto set = [&](Eigen::Index c) -> Eigen::VectorXd { return theta.row(theta.rows() == 1 ? 0 : c); };
    SpringCharacter character;
    const double unit = model.modulus_N_m;
    std::vector<double> force;
    for (Eigen::Index c = 0; c < model.case_count(); ++c) {
        const LoadCase& load = loads[static_cast<std::size_t>(c)];
        const Eigen::VectorXd away = (set(c) - model.heuristic_a) / unit;
        const std::vector<bool> is_near = near_springs(model.mesh, load.path->contact_m);
        std::vector<double> near, far;
        for (Eigen::Index s = 0; s < away.size(); ++s) (is_near[static_cast<std::size_t>(s)] ? near : far).push_back(away[s]);
        const auto rms_of = [](const std::vector<double>& v) {
            return rms(Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size())));
        };
        character.near.push_back(rms_of(near));
        character.far.push_back(rms_of(far));
        force.push_back(resolved_force(model.mesh, *law, set(c),
                                       locate_on_surface(model.mesh, load.path->contact_m), load.path->direction,
                                       load.record->displacement));
    }

    constexpr double neighbour_cosine = 0.694;  // 46 degrees
    for (Eigen::Index a = 0; a < model.case_count(); ++a)
        for (Eigen::Index b = a + 1; b < model.case_count(); ++b) {
            const LoadCase &first = loads[static_cast<std::size_t>(a)], &second = loads[static_cast<std::size_t>(b)];
            const double distance = rms(set(a) - set(b)) / unit;
            if (first.path == second.path && b == a + 1) {
                character.magnitude_step.push_back(distance);
                ++character.force_steps;
                const bool fe_rises = second.record->contact_force_N.dot(second.path->direction) >
                                      first.record->contact_force_N.dot(first.path->direction);
                if (fe_rises && force[static_cast<std::size_t>(b)] < force[static_cast<std::size_t>(a)])
                    ++character.force_falls;
            } else if (first.path != second.path && first.path->contact_m == second.path->contact_m &&
                       first.record->magnitude_m == second.record->magnitude_m &&
                       first.path->direction.dot(second.path->direction) >= neighbour_cosine) {
                character.angle_step.push_back(distance);
            }
        }

    character.smallest_eigenvalue = std::numeric_limits<double>::infinity();
    for (Eigen::Index c = 0; c < theta.rows(); ++c) {
        const Eigen::VectorXd eigenvalues = supported_eigenvalues(model.mesh, *law, theta.row(c));
        character.smallest_eigenvalue = std::min(character.smallest_eigenvalue, eigenvalues[0] / unit);
        if (eigenvalues[0] < 1e-9 * eigenvalues[eigenvalues.size() - 1]) ++character.singular_sets;
    }
    return character;
}

std::vector<FrontPoint> ridge_front(const TrainedModel& model, const Cases& cases, double k_min_N_m, double k_max_N_m) {
    const std::unique_ptr<SpringLaw> law = make_spring_law(model.law);
    const std::vector<LoadCase> loads = load_cases(cases);
    const int S = model.mesh.spring_count(), D = model.mesh.dimension();
    const Box box{Eigen::VectorXd::Constant(S, k_min_N_m), Eigen::VectorXd::Constant(S, k_max_N_m)};
    std::vector<FrontPoint> front;
    for (double ridge : {0.0, 1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 10.0}) {
        NodeField theta(model.case_count(), S);
        std::vector<double> losses, distances;
        int not_converged = 0;
        for (Eigen::Index c = 0; c < model.case_count(); ++c) {
            const PathRecord& record = *loads[static_cast<std::size_t>(c)].record;
            const SparseMatrix A = law->force_matrix(model.mesh, record.displacement);
            const NodeField node_weight = model.books.node_weight.row(c).transpose().replicate(1, D);
            const Eigen::VectorXd weight = as_vector(node_weight), force = as_vector(record.force);
            const ForceLoss loss(A, force, weight);
            const double mean_column = loss.matrix().squaredNorm() / S;
            const BoundedLsqSummary fit = solve_bounded_lsq(
                with_ridge(A, force, weight, ridge * mean_column, model.heuristic_a), model.heuristic_a, box);
            theta.row(c) = fit.theta;
            not_converged += fit.status == LsqStatus::converged ? 0 : 1;
            losses.push_back(loss.relative(fit.theta));
            distances.push_back(rms(fit.theta - model.heuristic_a) / model.modulus_N_m);
        }
        const SpringCharacter character = spring_character(model, cases, theta);
        front.push_back({ridge, statistics_of(losses).median, statistics_of(distances).median, character.force_falls,
                         character.smallest_eigenvalue, not_converged});
    }
    return front;
}

}  // namespace tissue
