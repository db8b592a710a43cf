#include "train/train_law.h"

#include <fmt/format.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

#include <chrono>
#include <cmath>
#include <memory>

#include "error.h"
#include "parallel.h"

namespace tissue {
namespace {

int rows_of(const PressPath::Record& record) { return 2 + static_cast<int>(record.displacement.size()); }

}  // namespace

std::vector<PressPath> press_paths(const Cases& cases, const SpringMesh& mesh) {
    const Outline outline(mesh);
    std::vector<PressPath> paths;
    for (const LoadPath& path : cases.paths) {
        if (path.role != "train") continue;
        PressPath& out = paths.emplace_back();
        out.name = path.name;
        out.arc_m = outline.arc_of(path.contact_m);
        for (const PathRecord& record : path.records) {
            const bool asked = cases.magnitudes_m.empty() ||
                               std::any_of(cases.magnitudes_m.begin(), cases.magnitudes_m.end(),
                                           [&](double m) { return std::abs(m - record.magnitude_m) < 1e-9; });
            if (asked && record.magnitude_m > 0)
                out.records.push_back({path.push_m(record), record.contact_force_N, record.displacement});
        }
        if (out.records.empty()) paths.pop_back();
    }
    return paths;
}

int law_residual_count(const EnergyLaw& law, const std::vector<PressPath>& paths) {
    int rows = law.size();
    for (const PressPath& path : paths)
        for (const PressPath::Record& record : path.records) rows += rows_of(record);
    return rows;
}

void law_residuals(const SpringMesh& mesh, const EnergyLaw& law, const std::vector<PressPath>& paths,
                   const LawTrainingOptions& options, const Eigen::VectorXd& p, Eigen::Ref<Eigen::VectorXd> f,
                   Eigen::Ref<RowMatrix> J, std::vector<std::string>* lost) {
    const TissueEnergy energy = law.energy(mesh);
    const ContactSurface surface(mesh);
    const Eigen::VectorXd constants = law.constants(p);
    const Eigen::MatrixXd constants_by = law.constants_by(p);
    const PatchLaw patch_law = law.patch(p);

    std::vector<int> first_row;
    int rows = 0, records = 0;
    for (const PressPath& path : paths) {
        first_row.push_back(rows);
        for (const PressPath::Record& record : path.records) rows += rows_of(record);
        records += static_cast<int>(path.records.size());
    }
    const double share = 1 / std::sqrt(static_cast<double>(records));
    std::vector<std::vector<std::string>> lost_of(paths.size());
    parallel_for(static_cast<int>(paths.size()), options.threads, [&](int i) {
        const PressPath& path = paths[static_cast<std::size_t>(i)];
        PressSolver solver(energy, surface, options.press);
        const ContactPatch patch = surface.at(path.arc_m);
        const PatchSpring contact(patch, patch_law.at(patch));
        const Eigen::MatrixXd stiffness_by = law.stiffness_by(p, patch);
        PressState state;
        bool reached = true;
        Eigen::Index row = first_row[static_cast<std::size_t>(i)];
        for (const PressPath::Record& record : path.records) {
            const PressState before = state;
            if (reached) state = solver.press(constants, contact, record.push_m, before.displacement.size() > 0 ? &before : nullptr);
            reached = state.status != PressStatus::lost;
            if (state.status != PressStatus::held)
                lost_of[static_cast<std::size_t>(i)].push_back(
                    fmt::format("{} at {:.3g} mm: {} at {:.3g} mm", path.name, 1e3 * record.push_m.norm(),
                                to_string(state.status), 1e3 * state.push_m.norm()));
            const Eigen::Index dofs = record.displacement.size();
            const double per_force = share / (options.force_scale * record.force_N.norm());
            const double per_shape = dofs > 0 ? share / (options.shape_scale * record.displacement.norm()) : 0;
            if (reached) {
                const PressDerivative by = solver.derivative(constants_by, stiffness_by);
                f.segment(row, 2) = per_force * (state.contact_force_N - record.force_N);
                J.middleRows(row, 2) = per_force * by.contact_force;
                if (dofs > 0) {
                    f.segment(row + 2, dofs) = per_shape * (as_vector(state.displacement) - as_vector(record.displacement));
                    J.middleRows(row + 2, dofs) = per_shape * by.displacement;
                }
            } else {
                f.segment(row, 2) = -per_force * record.force_N;
                if (dofs > 0) f.segment(row + 2, dofs) = -per_shape * as_vector(record.displacement);
                J.middleRows(row, 2 + dofs).setZero();
            }
            row += 2 + dofs;
        }
    });
    f.segment(rows, p.size()) = options.ridge * p;
    J.middleRows(rows, p.size()) = options.ridge * Eigen::MatrixXd::Identity(p.size(), p.size());
    if (lost)
        for (const auto& list : lost_of) lost->insert(lost->end(), list.begin(), list.end());
}

double heuristic_factor(const SpringMesh& mesh, const EnergyLaw& law, const std::vector<PressPath>& paths,
                        const LawTrainingOptions& options) {
    const TissueEnergy energy = law.energy(mesh);
    const ContactSurface surface(mesh);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(law.size()), constants = law.constants(zero);
    std::vector<Eigen::Vector2d> sums(paths.size(), Eigen::Vector2d::Zero());  // of f.F / F.F and f.f / F.F
    parallel_for(static_cast<int>(paths.size()), options.threads, [&](int i) {
        const PressPath& path = paths[static_cast<std::size_t>(i)];
        PressSolver solver(energy, surface, options.press);
        const ContactPatch patch = surface.at(path.arc_m);
        PressState state;
        for (const PressPath::Record& record : path.records) {
            const PressState before = state;
            state = solver.press(constants, {patch, law.patch(zero).at(patch)}, record.push_m,
                                 before.displacement.size() > 0 ? &before : nullptr);
            if (state.status == PressStatus::lost) break;
            const Eigen::Vector2d &f = state.contact_force_N, &F = record.force_N;
            if (F.squaredNorm() > 0)
                sums[static_cast<std::size_t>(i)] += Eigen::Vector2d(f.dot(F), f.dot(f)) / F.squaredNorm();
        }
    });
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& s : sums) sum += s;
    if (!(sum[0] > 0)) throw MismatchError("no load path has a force that the heuristic's own could be scaled to");
    return sum[0] / sum[1];
}

TrainedLaw train_law(const SpringMesh& mesh, const EnergyLaw& law, const std::vector<PressPath>& paths,
                     const LawTrainingOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    if (paths.empty()) throw MismatchError("there are no load paths to train a law on");
    if (law.size() == 0) throw MismatchError("a law without terms has nothing to train");
    const std::unique_ptr<gsl_rng, void (*)(gsl_rng*)> rng(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free);
    gsl_rng_set(rng.get(), options.seed);
    const int rows = law_residual_count(law, paths);
    const FitFunction residuals = [&](const Eigen::VectorXd& p, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J) {
        law_residuals(mesh, law, paths, options, p, f, J);
    };
    TrainedLaw trained;
    for (int s = 0; s < options.starts; ++s) {
        Eigen::VectorXd start = Eigen::VectorXd::Zero(law.size());
        for (double& p : start)
            if (s > 0) p = gsl_ran_gaussian(rng.get(), options.spread);
        trained.starts.push_back(nonlinear_fit(residuals, rows, start, options.fit));
        if (trained.starts.back().half_square < trained.starts[trained.kept].half_square) trained.kept = trained.starts.size() - 1;
    }
    const FitResult& best = trained.starts[trained.kept];
    trained.coefficients = best.x;
    trained.objective = 2 * best.half_square;
    Eigen::VectorXd f(rows);
    RowMatrix J(rows, law.size());
    law_residuals(mesh, law, paths, options, best.x, f, J, &trained.lost);
    trained.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return trained;
}

}  // namespace tissue
