#include "adapt/next_measurement.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "error.h"

namespace tissue {
namespace {

/// The indentations with an equilibrium (n).
struct Answers {
    std::vector<std::size_t> which;  ///< their indices
    Eigen::MatrixXd by_x;            ///< dF/dx over |F| of each, stacked (n*D x P)
    std::vector<double> sd;          ///< standard deviation of a component of each force, over its size
};

Answers answers_to(Adaptation& adaptation, const std::vector<Push>& pushes, const std::function<void()>& between) {
    const Eigen::Index D = adaptation.base().mesh.dimension(), P = adaptation.unknowns().size();
    Answers answers;
    answers.by_x.resize(D * static_cast<Eigen::Index>(pushes.size()), P);
    for (std::size_t i = 0; i < pushes.size(); ++i) try {
            if (between) between();
            const Expected expected = adaptation.expect(pushes[i].contact_m, pushes[i].push_m);
            if (expected.status != SolverStatus::converged) continue;
            answers.by_x.middleRows(D * static_cast<Eigen::Index>(answers.which.size()), D) = expected.by_x;
            answers.which.push_back(i);
            answers.sd.push_back(std::sqrt(adaptation.covariance(expected, false).trace() / static_cast<double>(D)));
        } catch (const MismatchError&) {  // an invalid contact, for example on fixed nodes
        }
    answers.by_x.conservativeResize(D * static_cast<Eigen::Index>(answers.which.size()), P);
    return answers;
}

}  // namespace

std::vector<Push> pushes_over(const FreeSurface& surface, const SpringMesh& mesh, double depth_m, double apart_m) {
    if (!(depth_m > 0 && std::isfinite(depth_m))) throw MismatchError(fmt::format("the tool displacement is {:g} mm, must be finite and more than 0", 1e3 * depth_m));
    std::vector<Push> pushes;
    const auto far_from_others = [&](const Point& at) {
        for (const Push& other : pushes)
            if ((other.contact_m - at).norm() < 0.95 * apart_m) return false;
        for (int node : mesh.fixed)
            if ((mesh.nodes.row(node).transpose() - at).norm() < apart_m) return false;
        return true;
    };
    const auto add = [&](const Point& at) {
        const FreeSurface::Place place = surface.nearest(at);
        if (far_from_others(place.point_m)) pushes.push_back({place.point_m, depth_m * place.inward});
    };
    for (int node : surface.nodes()) add(mesh.nodes.row(node).transpose());
    for (Eigen::Index f = 0; f < surface.facets().rows(); ++f)
        add(surface.at(f, mesh.is_solid() ? Eigen::Vector3d::Constant(1.0 / 3) : Eigen::Vector3d(0.5, 0.5, 0)));
    return pushes;
}

std::vector<MeasurementGain> rank_measurements(Adaptation& adaptation, const std::vector<Push>& may_be, const std::vector<Push>& judged, const std::function<void()>& between) {
    const Answers possible = answers_to(adaptation, may_be, between), to_predict = answers_to(adaptation, judged, between);
    const Eigen::MatrixXd &H = possible.by_x, &T = to_predict.by_x;
    const Eigen::Index D = adaptation.base().mesh.dimension();
    const Eigen::MatrixXd PH = adaptation.state().P * H.transpose(), TPH = T * PH;
    const double all = (T * adaptation.state().P).cwiseProduct(T).sum();
    const AdaptOptions& options = adaptation.options();
    const double noise = options.force_noise * options.force_noise + options.model_error * options.model_error;
    std::vector<MeasurementGain> worth;
    for (std::size_t i = 0; i < possible.which.size(); ++i) {
        const Eigen::Index at = D * static_cast<Eigen::Index>(i);
        const Eigen::MatrixXd own = H.middleRows(at, D) * PH.middleCols(at, D);
        const Eigen::MatrixXd S = own + noise * Eigen::MatrixXd::Identity(D, D), there = TPH.middleCols(at, D);
        const double gone = there.cwiseProduct(S.ldlt().solve(there.transpose()).transpose()).sum();
        worth.push_back({possible.which[i], all > 0 ? gone / all : 0, possible.sd[i]});
    }
    std::stable_sort(worth.begin(), worth.end(), [](const MeasurementGain& a, const MeasurementGain& b) { return a.gain > b.gain; });
    return worth;
}

}  // namespace tissue
