#include "train/train_energy_model.h"

#include <fmt/format.h>
#include <gsl/gsl_randist.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>

#include "error.h"
#include "gsl.h"
#include "parallel.h"
#include "springs/energy_model_kernel.h"

namespace tissue {
namespace {

/// Number of residuals for the displacement: D for every compared node.
Eigen::Index shape_rows(const IndentationPath::Record& record, const EnergyModelTrainingOptions& options) {
    const bool all = options.compared.empty() || record.displacement.size() == 0;
    return all ? record.displacement.size() : static_cast<Eigen::Index>(options.compared.size()) * record.push_m.size();
}

int rows_of(const IndentationPath::Record& record, const EnergyModelTrainingOptions& options) {
    return static_cast<int>(record.push_m.size() + shape_rows(record, options));
}

/// Rows of a (N*D x .) matrix for the compared nodes (options.compared).
template <class Matrix>
Eigen::MatrixXd compared_rows(const Matrix& all, const EnergyModelTrainingOptions& options, Eigen::Index D) {
    if (options.compared.empty()) return all;
    Eigen::MatrixXd rows(D * static_cast<Eigen::Index>(options.compared.size()), all.cols());
    for (std::size_t i = 0; i < options.compared.size(); ++i)
        rows.middleRows(D * static_cast<Eigen::Index>(i), D) = all.middleRows(D * options.compared[i], D);
    return rows;
}

/// Skin of one contact (springs/skin.h). column: index of each skin parameter among the coefficients, or -1.
struct TrainedSkin {
    std::vector<SkinNode> nodes;
    SkinParameters law;
    std::array<Eigen::Index, 4> column;

    /// Applies the skin to a displacement (N x D) and to its derivative (N*D x P).
    void see(const Point& push_m, NodeField& u, Eigen::MatrixXd& by) const {
        for (const SkinNode& at : nodes) {
            u.row(at.node) = at.shown(u.row(at.node).transpose(), law, push_m).transpose();
            auto rows = by.middleRows<3>(3 * at.node);
            rows *= at.keep;
            for (std::size_t k = 0; k < column.size(); ++k)
                if (column[k] >= 0) rows.col(column[k]) += at.by[k] * Eigen::Vector3d(push_m);
        }
    }
};

/// Contact kernels of all disc radii of the paths; read by many threads.
class PathKernels {
   public:
    PathKernels(const SpringMesh& mesh, const EnergyModelTerms& model_terms, const std::vector<IndentationPath>& paths, const EnergyModelTrainingOptions& options) : own_m_(options.disc_radius_m) {
        for (const IndentationPath& path : paths) {
            std::unique_ptr<ContactKernel>& kernel = kernels_[path.radius_m];
            if (kernel) continue;
            const bool own = path.radius_m == 0 || path.radius_m == own_m_;
            kernel = make_contact_kernel(mesh, own ? own_m_ : path.radius_m, {model_terms.ground(), options.curved_range, own ? options.correction : options.sizes.correction_at(path.radius_m)});
        }
    }
    const ContactKernel& of(const IndentationPath& path) const { return *kernels_.at(path.radius_m); }
    /// Logarithm of the ratio of a path's disc radius to the model's own.
    double log_times(const IndentationPath& path) const { return path.radius_m > 0 ? std::log(path.radius_m / own_m_) : 0; }

   private:
    double own_m_;
    std::map<double, std::unique_ptr<ContactKernel>> kernels_;
};

}  // namespace

std::vector<IndentationPath> indentation_paths(const Cases& cases) {
    std::vector<IndentationPath> paths;
    for (const LoadPath& path : cases.paths) {
        if (path.role != "train") continue;
        IndentationPath& out = paths.emplace_back();
        out.name = path.name;
        out.contact_m = path.contact_m;
        out.radius_m = path.radius_m;
        const std::vector<double> magnitudes_m = load_magnitudes(cases, path);
        for (const PathRecord& record : path.records) {
            const bool asked = magnitudes_m.empty() || std::any_of(magnitudes_m.begin(), magnitudes_m.end(), [&](double m) {
                                   return std::abs(m - record.magnitude_m) < 1e-9;
                               });
            if (asked && record.magnitude_m > 0)
                out.records.push_back({path.push_m(record), record.contact_force_N, record.displacement});
        }
        if (out.records.empty()) paths.pop_back();
    }
    return paths;
}

int energy_model_residual_count(const EnergyModelTerms& model_terms, const std::vector<IndentationPath>& paths, const EnergyModelTrainingOptions& options) {
    int rows = model_terms.size();
    for (const IndentationPath& path : paths)
        for (const IndentationPath::Record& record : path.records) rows += rows_of(record, options);
    return rows;
}

void energy_model_residuals(const SpringMesh& mesh, const EnergyModelTerms& model_terms, const std::vector<IndentationPath>& paths,
                   const EnergyModelTrainingOptions& options, const Eigen::VectorXd& p, Eigen::Ref<Eigen::VectorXd> f,
                   Eigen::Ref<RowMatrix> J, std::vector<std::string>* lost, PathEquilibria* rests, std::vector<char>* gone) {
    const TissueEnergy energy = model_terms.energy(mesh);
    const PathKernels kernels(mesh, model_terms, paths, options);
    const Eigen::Index D = mesh.dimension();
    if (rests) rests->resize(paths.size());
    const Eigen::VectorXd constants = model_terms.constants(p);
    const Eigen::MatrixXd constants_by = model_terms.constants_by(p);
    std::vector<int> first_row, first_record;
    int rows = 0, records = 0;
    for (const IndentationPath& path : paths) {
        first_row.push_back(rows);
        first_record.push_back(records);
        for (const IndentationPath::Record& record : path.records) rows += rows_of(record, options);
        records += static_cast<int>(path.records.size());
    }
    if (gone) gone->assign(static_cast<std::size_t>(records), 0);
    const double share = 1 / std::sqrt(static_cast<double>(records));
    std::vector<std::vector<std::string>> lost_of(paths.size());
    parallel_for(static_cast<int>(paths.size()), options.threads, [&](int i) {
        const IndentationPath& path = paths[static_cast<std::size_t>(i)];
        const ContactKernel& kernel = kernels.of(path);
        const double log_times = kernels.log_times(path);
        EquilibriumSolver solver(energy, kernel, options.equilibrium);
        const ContactSpring contact(kernel.rows_at(path.contact_m), model_terms.patch(p, log_times));
        const Eigen::MatrixXd stiffness_by = model_terms.stiffness_by(p, contact.rows.factors, contact.rows.log_scale, log_times);
        const TrainedSkin skin{kernel.skin_at(path.contact_m), model_terms.skin(p), skin_columns(model_terms.terms())};
        std::vector<EquilibriumState>* known = rests ? &(*rests)[static_cast<std::size_t>(i)] : nullptr;
        if (known) known->resize(path.records.size());
        std::size_t r = 0;
        EquilibriumState state;
        bool reached = true;
        Eigen::Index row = first_row[static_cast<std::size_t>(i)];
        auto record_number = static_cast<std::size_t>(first_record[static_cast<std::size_t>(i)]);
        for (const IndentationPath::Record& record : path.records) {
            const EquilibriumState before = state;
            EquilibriumState* rest = known ? &(*known)[r++] : nullptr;
            const bool warm = rest && rest->displacement.size() > 0;
            if (warm) state = solver.indent(constants, contact, record.push_m, rest);
            if (reached && (!warm || state.status != SolverStatus::converged))
                state = solver.indent(constants, contact, record.push_m, before.displacement.size() > 0 ? &before : nullptr);
            reached = state.status != SolverStatus::no_equilibrium;
            if (gone) (*gone)[record_number++] = !reached;
            if (rest) *rest = state.status == SolverStatus::converged ? state : EquilibriumState();
            if (state.status != SolverStatus::converged)
                lost_of[static_cast<std::size_t>(i)].push_back(
                    fmt::format("{} at {:.3g} mm: {} at {:.3g} mm", path.name, 1e3 * record.push_m.norm(),
                                to_string(state.status), 1e3 * state.push_m.norm()));
            const Eigen::Index dofs = shape_rows(record, options);
            const Eigen::VectorXd fe_displacement = dofs > 0 ? Eigen::VectorXd(compared_rows(as_vector(record.displacement), options, D)) : Eigen::VectorXd();
            const double per_force = share / (options.force_scale * record.force_N.norm());
            const double per_shape = dofs > 0 ? share / (options.shape_scale * fe_displacement.norm()) : 0;
            if (reached) {
                EquilibriumDerivative by = solver.derivative(constants_by, stiffness_by);
                NodeField seen = state.displacement;
                if (dofs > 0) skin.see(record.push_m, seen, by.displacement);
                f.segment(row, D) = per_force * (state.contact_force_N - record.force_N);
                J.middleRows(row, D) = per_force * by.contact_force;
                if (dofs > 0) {
                    f.segment(row + D, dofs) = per_shape * (compared_rows(as_vector(seen), options, D) - fe_displacement);
                    J.middleRows(row + D, dofs) = per_shape * compared_rows(by.displacement, options, D);
                }
            } else {
                f.segment(row, D) = -per_force * record.force_N;
                if (dofs > 0) f.segment(row + D, dofs) = -per_shape * fe_displacement;
                J.middleRows(row, D + dofs).setZero();
            }
            row += D + dofs;
        }
    });
    f.segment(rows, p.size()) = options.ridge * p;
    J.middleRows(rows, p.size()) = options.ridge * Eigen::MatrixXd::Identity(p.size(), p.size());
    if (lost)
        for (const auto& list : lost_of) lost->insert(lost->end(), list.begin(), list.end());
}

double heuristic_factor(const SpringMesh& mesh, const EnergyModelTerms& model_terms, const std::vector<IndentationPath>& paths,
                        const EnergyModelTrainingOptions& options) {
    const TissueEnergy energy = model_terms.energy(mesh);
    const PathKernels kernels(mesh, model_terms, paths, options);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(model_terms.size()), constants = model_terms.constants(zero);
    std::vector<Eigen::Vector2d> sums(paths.size(), Eigen::Vector2d::Zero());  // of f.F / F.F and f.f / F.F
    parallel_for(static_cast<int>(paths.size()), options.threads, [&](int i) {
        const IndentationPath& path = paths[static_cast<std::size_t>(i)];
        EquilibriumSolver solver(energy, kernels.of(path), options.equilibrium);
        const ContactSpring contact(kernels.of(path).rows_at(path.contact_m), model_terms.patch(zero, kernels.log_times(path)));
        EquilibriumState state;
        for (const IndentationPath::Record& record : path.records) {
            const EquilibriumState before = state;
            state = solver.indent(constants, contact, record.push_m,
                                 before.displacement.size() > 0 ? &before : nullptr);
            if (state.status == SolverStatus::no_equilibrium) break;
            const Point &f = state.contact_force_N, &F = record.force_N;
            if (F.squaredNorm() > 0)
                sums[static_cast<std::size_t>(i)] += Eigen::Vector2d(f.dot(F), f.dot(f)) / F.squaredNorm();
        }
    });
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& s : sums) sum += s;
    if (!(sum[0] > 0)) throw MismatchError("no load path has a force to which that of the heuristic could be scaled");
    return sum[0] / sum[1];
}

TrainedEnergyModel train_energy_model(const SpringMesh& mesh, const EnergyModelTerms& model_terms, const std::vector<IndentationPath>& paths,
                     const EnergyModelTrainingOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    if (paths.empty()) throw MismatchError("there are no load paths to train an energy model on");
    if (model_terms.size() == 0) throw MismatchError("an energy model without terms has no parameters to train");
    const Rng rng = seeded_rng(options.seed);
    const int rows = energy_model_residual_count(model_terms, paths, options);
    PathEquilibria rests;
    std::vector<char> gone;
    const FitFunction residuals = [&](const Eigen::VectorXd& p, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J) {
        energy_model_residuals(mesh, model_terms, paths, options, p, f, J, nullptr, mesh.is_solid() ? &rests : nullptr, &gone);
    };
    TrainedEnergyModel trained;
    for (int s = 0; s < options.starts; ++s) {
        Eigen::VectorXd start = s == 0 && options.first.size() > 0 ? options.first : Eigen::VectorXd::Zero(model_terms.size());
        for (double& p : start)
            if (s > 0) p = gsl_ran_gaussian(rng.get(), options.spread);
        rests.clear();
        trained.starts.push_back(nonlinear_fit(residuals, rows, start, options.fit, &gone));
        const FitResult &last = trained.starts.back(), &kept = trained.starts[trained.kept];
        if (std::tie(last.lost, last.half_square) < std::tie(kept.lost, kept.half_square)) trained.kept = trained.starts.size() - 1;
    }
    const FitResult& best = trained.starts[trained.kept];
    trained.coefficients = best.x;
    trained.objective = 2 * best.half_square;
    Eigen::VectorXd f(rows);
    RowMatrix J(rows, model_terms.size());
    energy_model_residuals(mesh, model_terms, paths, options, best.x, f, J, &trained.lost);
    trained.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return trained;
}

}  // namespace tissue
