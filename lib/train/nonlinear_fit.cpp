#include "train/nonlinear_fit.h"

#include <Eigen/Dense>
#include <fmt/format.h>
#include <gsl/gsl_multifit_nlinear.h>

#include <algorithm>
#include <exception>
#include <memory>

#include "error.h"
#include "gsl.h"

namespace tissue {
namespace {

Eigen::Map<const Eigen::VectorXd, 0, Eigen::InnerStride<>> view(const gsl_vector* v) {
    return {v->data, static_cast<Eigen::Index>(v->size), Eigen::InnerStride<>(static_cast<Eigen::Index>(v->stride))};
}

/// f and J at the last x. GSL requests f at every trial point, and J at the start and at accepted points only.
struct Memory {
    const FitFunction& function;
    const std::vector<char>* lost;
    Eigen::VectorXd x, f;
    RowMatrix J;
    int evaluations = 0;
    std::exception_ptr failure;
    std::vector<char> lost_here;  ///< lost parts at the current (last accepted) point
    double norm_here = 0;         ///< |f| at the current point
    Eigen::VectorXd x_here;       ///< the current point
    double most_step;
    bool rejected = false;  ///< whether a step was rejected because it loses a part

    int at(const gsl_vector* where) noexcept {
        if (evaluations > 0 && x == view(where)) return GSL_SUCCESS;
        try {
            x = view(where);
            if (evaluations > 0 && (x - x_here).lpNorm<Eigen::Infinity>() > most_step) {
                f.setConstant(1 + norm_here);
                return GSL_SUCCESS;
            }
            ++evaluations;
            function(x, f, J);
            if (loses()) {
                f.setConstant(1 + norm_here);  // larger than |f| at the current point: GSL rejects the step
                rejected = true;
            }
        } catch (...) {
            failure = std::current_exception();
            return GSL_EFAILED;
        }
        return GSL_SUCCESS;
    }

    /// Whether a part has a value at the current point and none at the last x.
    bool loses() const {
        if (!lost || lost_here.empty()) return false;
        for (std::size_t i = 0; i < lost->size(); ++i)
            if ((*lost)[i] && !lost_here[i]) return true;
        return false;
    }
    void stand_here() {
        if (lost) lost_here = *lost;
        norm_here = f.norm();
        x_here = x;
    }
};

int fill_f(const gsl_vector* x, void* memory, gsl_vector* out) {
    auto& m = *static_cast<Memory*>(memory);
    const int status = m.at(x);
    if (status == GSL_SUCCESS) Eigen::Map<Eigen::VectorXd>(out->data, m.f.size()) = m.f;
    return status;
}

int fill_J(const gsl_vector* x, void* memory, gsl_matrix* out) {
    auto& m = *static_cast<Memory*>(memory);
    const int status = m.at(x);
    if (status != GSL_SUCCESS) return status;
    m.stand_here();
    Eigen::Map<RowMatrix>(out->data, m.J.rows(), m.J.cols()) = m.J;
    return status;
}

/// Whether the Gauss-Newton step from the current point exceeds ten times step_tolerance, and its predicted decrease of
/// |f|^2 ten times gain_tolerance.
bool promises_more(const gsl_multifit_nlinear_workspace& work, const RowMatrix& J, const FitOptions& options) {
    const Eigen::VectorXd g = view(work.g), step = (J.transpose() * J).ldlt().solve(g);
    return step.lpNorm<Eigen::Infinity>() > 10 * options.step_tolerance && g.dot(step) > 10 * options.gain_tolerance * view(work.f).squaredNorm();
}

}  // namespace

const char* to_string(FitStatus status) {
    switch (status) {
        case FitStatus::small_gradient:
            return "small_gradient";
        case FitStatus::small_step:
            return "small_step";
        case FitStatus::small_gain:
            return "small_gain";
        case FitStatus::no_progress:
            return "no_progress";
        case FitStatus::held_back:
            return "held_back";
        case FitStatus::iterations_done:
            return "iterations_done";
    }
    return "unknown";
}

FitResult nonlinear_fit(const FitFunction& function, int residuals, const Eigen::VectorXd& start, const FitOptions& options,
                        const std::vector<char>* lost) {
    const Eigen::Index P = start.size();
    if (P < 1 || residuals < P)
        throw MismatchError(fmt::format("a fit of {} parameters to {} residuals is not possible", P, residuals));
    Memory memory{function, lost, {}, Eigen::VectorXd::Zero(residuals), RowMatrix::Zero(residuals, P), 0, nullptr, {}, 0, {}, options.most_step, false};
    gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
    parameters.trs = gsl_multifit_nlinear_trs_lm;
    parameters.scale = gsl_multifit_nlinear_scale_more;
    parameters.solver = gsl_multifit_nlinear_solver_mcholesky;
    const auto n = static_cast<std::size_t>(residuals), p = static_cast<std::size_t>(P);
    const std::unique_ptr<gsl_multifit_nlinear_workspace, void (*)(gsl_multifit_nlinear_workspace*)> work(
        gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, n, p), gsl_multifit_nlinear_free);
    if (!work) throw MismatchError(fmt::format("a fit of {} parameters to {} residuals needs more memory than there is", P, residuals));
    gsl_multifit_nlinear_fdf fdf{};
    fdf.f = fill_f;
    fdf.df = fill_J;
    fdf.n = n;
    fdf.p = p;
    fdf.params = &memory;

    Eigen::VectorXd x = start;
    const gsl_vector_const_view at = gsl_vector_const_view_array(x.data(), p);
    int outcome = gsl_multifit_nlinear_init(&at.vector, &fdf, work.get());
    FitResult result;
    while (outcome == GSL_SUCCESS && result.iterations < options.max_iterations) {
        const double before = view(work->f).squaredNorm();
        if (view(work->g).lpNorm<Eigen::Infinity>() <= options.gradient_tolerance * before) {
            result.status = FitStatus::small_gradient;
            break;
        }
        outcome = gsl_multifit_nlinear_iterate(work.get());
        if (outcome != GSL_SUCCESS) break;
        ++result.iterations;
        if (view(work->dx).lpNorm<Eigen::Infinity>() <= options.step_tolerance) {
            result.status = FitStatus::small_step;
            break;
        }
        if (before - view(work->f).squaredNorm() <= options.gain_tolerance * before) {
            result.status = FitStatus::small_gain;
            break;
        }
    }
    if (memory.failure) std::rethrow_exception(memory.failure);
    if (outcome == GSL_ENOPROG)
        result.status = FitStatus::no_progress;
    else if (outcome != GSL_SUCCESS)
        throw MismatchError(fmt::format("the fit failed: {}", gsl_strerror(outcome)));
    const bool small = result.status == FitStatus::small_step || result.status == FitStatus::small_gain;
    if (small && memory.rejected && promises_more(*work, memory.J, options)) result.status = FitStatus::held_back;
    result.x = view(work->x);
    result.half_square = view(work->f).squaredNorm() / 2;
    result.gradient = view(work->g).lpNorm<Eigen::Infinity>();
    result.evaluations = memory.evaluations;
    result.lost = static_cast<int>(std::count(memory.lost_here.begin(), memory.lost_here.end(), 1));
    return result;
}

}  // namespace tissue
