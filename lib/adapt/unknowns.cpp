#include "adapt/unknowns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "error.h"
#include "mesh/free_surface.h"
#include "mesh/topology.h"
#include "springs/energy_model_terms.h"

namespace tissue {
namespace {

/// Matrix (E x N) that maps values of nodes to means over the nodes of each element.
Unknowns::Rows element_means(const TissueEnergy& energy) {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t k = 0; k < energy.kinds().size(); ++k) {
        const Cells& nodes = energy.kinds()[k]->nodes();
        for (Eigen::Index e = 0; e < nodes.rows(); ++e)
            for (int node : nodes.row(e))
                entries.emplace_back(static_cast<int>(energy.first_of(k) + e), node, 1.0 / static_cast<double>(nodes.cols()));
    }
    Unknowns::Rows mean(energy.constant_count(), energy.node_count());
    mean.setFromTriplets(entries.begin(), entries.end());
    return mean;
}

/// Prior covariance (P x P) of unknowns at places (P x D): common^2 + local^2 exp(-d^2 / (2 length^2)).
Eigen::MatrixXd covariance(const TissueModel& model, const NodeField& place_m, const PriorOptions& options) {
    const double length_m = options.length_m > 0 ? options.length_m : 2 * FreeSurface(model.mesh).spacing_m();
    const Eigen::Index P = place_m.rows();
    Eigen::MatrixXd prior(P, P);
    for (Eigen::Index i = 0; i < P; ++i)
        for (Eigen::Index j = 0; j < P; ++j) {
            const double away = (place_m.row(i) - place_m.row(j)).squaredNorm() / (2 * length_m * length_m);
            prior(i, j) = options.common * options.common + options.local * options.local * std::exp(-away);
        }
    return prior;
}

/// Matrix (rows x columns) with a 1 in row i at column first + i, else 0.
Unknowns::Rows one_each(Eigen::Index rows, Eigen::Index columns, Eigen::Index first) {
    Unknowns::Rows each(rows, columns);
    each.reserve(Eigen::VectorXi::Ones(rows));
    for (Eigen::Index i = 0; i < rows; ++i) each.insert(i, first + i) = 1;
    each.makeCompressed();
    return each;
}

/// Fills the unknowns of kind `terms`: a uniform scale, and the terms over the constants of the trained model.
void add_terms(const TissueModel& model, Unknowns& u, const PriorOptions& options) {
    const EnergyModel& energy_model = *model.energy_model;
    EnergyModelHeuristic now;
    now.incompressible = energy_model.incompressible;
    now.constants = energy_model.constants;
    now.cap = 1e6 * energy_model.constants.segment(model.mesh.springs.rows(), cell_count(model.mesh));
    now.patch = energy_model.patch;
    for (const std::string& term : energy_model.terms)
        if (term.find("nodule") != std::string::npos || term.find("ground") != std::string::npos)
            throw MismatchError(fmt::format("unknowns 'terms' do not support term '{}', which depends on data of the study; use 'field'", term));
    // Forces do not depend on the skin; forces of the model's own disc do not depend on terms of the disc size
    std::vector<std::string> kept = energy_model.terms;
    kept.erase(std::remove_if(kept.begin(), kept.end(), [](const std::string& term) { return is_skin_term(term) || is_size_term(term); }), kept.end());
    const EnergyModelTerms terms(model.mesh, now, kept);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(terms.size());
    const Eigen::Index P = terms.size() + 1;
    u.terms = kept;
    u.terms.insert(u.terms.begin(), "scale");
    Eigen::MatrixXd by_constant = Eigen::MatrixXd::Ones(energy_model.constants.size(), P), by_node = Eigen::MatrixXd::Zero(model.mesh.node_count(), P);
    by_constant.rightCols(P - 1) = energy_model.constants.cwiseInverse().asDiagonal() * terms.constants_by(zero);
    by_node.col(0).setOnes();
    u.by_constant = by_constant.sparseView();
    u.by_node = by_node.sparseView();
    for (Eigen::Index p = 0; p < P; ++p) {
        Eigen::MatrixXd by = Eigen::MatrixXd::Zero(energy_model.patch.log_N_m.rows(), energy_model.patch.log_N_m.cols());
        if (p > 0) by = terms.patch(Eigen::VectorXd::Unit(P - 1, p - 1)).log_N_m - energy_model.patch.log_N_m;
        u.by_patch.push_back(by);
    }
    u.prior = Eigen::MatrixXd::Identity(P, P) * options.term * options.term;
    u.prior(0, 0) = options.common * options.common;
}

}  // namespace

const std::vector<std::string>& unknown_kinds() {
    static const std::vector<std::string> kinds = {"scale", "terms", "field", "elements"};
    return kinds;
}

Unknowns make_unknowns(const TissueModel& model, const std::string& kind, const PriorOptions& options) {
    if (!model.energy_model) throw MismatchError("only an energy model learns from measurements; this model has spring sets");
    const EnergyModel& energy_model = *model.energy_model;
    const Eigen::Index E = energy_model.constants.size(), N = model.mesh.node_count();
    Unknowns u;
    u.kind = kind;
    if (kind == "scale") {
        u.by_constant = Eigen::MatrixXd::Ones(E, 1).sparseView();
        u.by_node = Eigen::MatrixXd::Ones(N, 1).sparseView();
        u.prior = Eigen::MatrixXd::Constant(1, 1, options.common * options.common + options.local * options.local);
    } else if (kind == "terms") {
        add_terms(model, u, options);
    } else if (kind == "field") {
        // a node of the solid has the interpolated unknown of its cube
        const Embedding& embedding = model.mesh.embedding;
        const Eigen::Index K = embedding.node_count(), L = N - K;
        u.place_m = model.mesh.nodes.bottomRows(L);
        u.by_constant = element_means(TissueEnergy(model.mesh, energy_model)).rightCols(L);
        std::vector<Eigen::Triplet<double>> entries;
        for (int i = 0; i < K; ++i)
            for (int k = 0; k < 8; ++k) entries.emplace_back(i, embedding.corner(i, k) - static_cast<int>(K), embedding.weight(i, k));
        for (int i = 0; i < L; ++i) entries.emplace_back(static_cast<int>(K) + i, i, 1.0);
        u.by_node.resize(N, L);
        u.by_node.setFromTriplets(entries.begin(), entries.end());
        u.prior = covariance(model, u.place_m, options);
    } else if (kind == "elements") {
        u.place_m.resize(E + N, model.mesh.dimension());
        u.place_m << NodeField(element_means(TissueEnergy(model.mesh, energy_model)) * model.mesh.nodes), model.mesh.nodes;
        u.by_constant = one_each(E, E + N, 0);
        u.by_node = one_each(N, E + N, E);
        u.prior = covariance(model, u.place_m, options);
    } else {
        throw MismatchError(fmt::format("unknowns '{}' are not known; allowed: {}", kind, fmt::join(unknown_kinds(), ", ")));
    }
    return u;
}

EnergyModel with_unknowns(const EnergyModel& energy_model, const Unknowns& unknowns, const Eigen::VectorXd& x) {
    EnergyModel now = energy_model;
    now.constants = energy_model.constants.array() * (unknowns.by_constant * x).array().exp();
    now.contact_log_scale = unknowns.by_node * x;
    if (energy_model.contact_log_scale.size() > 0) now.contact_log_scale += energy_model.contact_log_scale;
    for (std::size_t p = 0; p < unknowns.by_patch.size(); ++p) now.patch.log_N_m += x[static_cast<Eigen::Index>(p)] * unknowns.by_patch[p];
    return now;
}

}  // namespace tissue
