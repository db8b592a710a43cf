#include "springs/lattice_correction.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "error.h"
#include "mesh/embedded_lattice.h"
#include "mesh/free_surface.h"
#include "parallel.h"
#include "springs/contact_errors.h"
#include "springs/contact_spring.h"
#include "springs/energy_model_terms.h"
#include "springs/energy_model_kernel.h"
#include "springs/sparse_factor.h"
#include "springs/tissue_energy.h"

namespace tissue {
namespace {

constexpr double most = 0.5;          // bound of |x|
constexpr int most_nodes = 10'000;    // of one lattice; its compliance takes up to 0.7 GB
constexpr int at_once = 2;            // lattices treated in parallel
// points are moved towards the facet's middle by this part of the way, so that at a crease they have the facet's own
// normal
constexpr double into_facet = 1e-3;

/// Log of a contact's stiffness at rest, and its derivative by x.
struct Stiffness {
    double log, by_x;
};

/// Compliance of a lattice at rest between those of its nodes that contacts couple.
class NodeCompliance {
   public:
    NodeCompliance(const SpringMesh& mesh, const EnergyModel& energy_model, const std::vector<int>& nodes) : number_(static_cast<std::size_t>(mesh.node_count()), -1) {
        const int own = mesh.embedding.node_count(), lattice = mesh.node_count() - own;
        SparseFactor factor;
        const SparseFactor::Matrix K = TissueEnergy(mesh, energy_model).tangent(energy_model.constants, NodeField::Zero(mesh.node_count(), 3)).bottomRightCorner(3 * lattice, 3 * lattice);
        factor.analyse(K);
        if (!factor.factorise(K) || !factor.is_definite()) throw MismatchError("the lattice has zero-energy modes");
        const auto U = static_cast<Eigen::Index>(nodes.size());
        for (Eigen::Index k = 0; k < U; ++k) number_[static_cast<std::size_t>(nodes[static_cast<std::size_t>(k)])] = static_cast<int>(k);
        values_.resize(3 * U, 3 * U);
        constexpr Eigen::Index batch = 8;
        for (Eigen::Index first = 0; first < U; first += batch) {
            const Eigen::Index count = std::min(batch, U - first);
            Eigen::MatrixXd load = Eigen::MatrixXd::Zero(3 * lattice, 3 * count);
            for (Eigen::Index k = 0; k < count; ++k)
                for (int d = 0; d < 3; ++d) load(3 * (nodes[static_cast<std::size_t>(first + k)] - own) + d, 3 * k + d) = 1;
            const Eigen::MatrixXd u = factor.solve(load);
            for (Eigen::Index k = 0; k < U; ++k) values_.block(3 * k, 3 * first, 3, 3 * count) = u.middleRows(3 * (nodes[static_cast<std::size_t>(k)] - own), 3).cast<float>();
        }
    }

    /// Compliance between the nodes of a contact [m/N] (3K x 3K).
    Eigen::MatrixXd among(const std::vector<int>& nodes) const {
        const auto K = static_cast<Eigen::Index>(nodes.size());
        const auto at = [&](Eigen::Index k) { return 3 * static_cast<Eigen::Index>(number_[static_cast<std::size_t>(nodes[static_cast<std::size_t>(k)])]); };
        Eigen::MatrixXd some(3 * K, 3 * K);
        for (Eigen::Index b = 0; b < K; ++b)
            for (Eigen::Index a = 0; a < K; ++a) some.block<3, 3>(3 * a, 3 * b) = values_.block<3, 3>(at(a), at(b)).cast<double>();
        return some;
    }

   private:
    std::vector<int> number_;
    Eigen::MatrixXf values_;  // float: there are a thousand nodes and more
};

/// Stiffness of the contact in series with the lattice. With du = C pull' f and f = k (push d - pull du) for each row,
/// f = (1/k + pull C pull')^-1 push d.
Stiffness stiffness_of(const ContactSpring& contact, const NodeCompliance& compliance) {
    std::vector<Eigen::Index> stiff;
    for (Eigen::Index r = 0; r < contact.k_N_m.size(); ++r)
        if (contact.k_N_m[r] > 0) stiff.push_back(r);
    const Eigen::SparseMatrix<double> pull = contact.rows.pull(stiff, Eigen::all).sparseView();
    const Eigen::MatrixXd push = contact.rows.push(stiff, Eigen::all), carried = compliance.among(contact.rows.nodes) * pull.transpose();
    const Eigen::VectorXd give = contact.k_N_m(stiff).cwiseInverse();
    Eigen::MatrixXd system = pull * carried;
    system.diagonal() += give;
    const Eigen::MatrixXd f = system.ldlt().solve(push);
    const double stiffness = push.cwiseProduct(f).sum();
    return {std::log(stiffness), f.cwiseAbs2().cwiseProduct(give.replicate<1, 3>()).sum() / stiffness};
}

/// By disc and place; empty where there is no contact.
using Stiffnesses = std::vector<std::vector<std::optional<Stiffness>>>;

Stiffnesses stiffness_at(const SpringMesh& mesh, const EnergyModel& energy_model, const std::vector<Point>& places, const Eigen::VectorXd& radii_m) {
    const auto K = static_cast<std::size_t>(radii_m.size());
    std::vector<std::unique_ptr<ContactKernel>> kernels;
    for (double radius_m : radii_m) kernels.push_back(make_contact_kernel(mesh, radius_m, {energy_model.disc.ground, energy_model.disc.curved_range, {}}));
    std::vector<char> touched(static_cast<std::size_t>(mesh.node_count()), 0);
    std::vector<std::vector<char>> has_contact(K, std::vector<char>(places.size(), 0));
    for (std::size_t k = 0; k < K; ++k)
        for (std::size_t p = 0; p < places.size(); ++p) try {
                for (int node : kernels[k]->rows_at(places[p]).nodes) touched[static_cast<std::size_t>(node)] = 1;
                has_contact[k][p] = 1;
            } catch (const NoContactError&) {
            }
    std::vector<int> nodes;
    for (int node = 0; node < mesh.node_count(); ++node)
        if (touched[static_cast<std::size_t>(node)]) nodes.push_back(node);
    const NodeCompliance compliance(mesh, energy_model, nodes);
    Stiffnesses stiffness(K, std::vector<std::optional<Stiffness>>(places.size()));
    for (std::size_t k = 0; k < K; ++k) {
        const double log_times = std::log(radii_m[static_cast<Eigen::Index>(k)] / energy_model.disc_radius_m);
        const ContactParameters patch = log_times == 0 ? energy_model.patch : resized(energy_model.patch, energy_model.terms, energy_model.coefficients, energy_model.disc_radius_m, mesh.embedding.spacing_m, log_times);
        // rows are computed again: those of all places would take gigabytes
        for (std::size_t p = 0; p < places.size(); ++p)
            if (has_contact[k][p]) stiffness[k][p] = stiffness_of(ContactSpring(kernels[k]->rows_at(places[p]), patch), compliance);
    }
    return stiffness;
}

}  // namespace

std::vector<FacetTable> lattice_corrections(const Shape& shape, const SpringMesh& mesh, const std::function<EnergyModel(const SpringMesh&)>& energy_model_on, const Eigen::VectorXd& radii_m, int threads) {
    if (mesh.node_count() - mesh.embedding.node_count() > most_nodes) return {};
    const FreeSurface surface(mesh);
    const double h = mesh.embedding.spacing_m;
    const int parts = std::clamp(static_cast<int>(std::ceil(3 * surface.spacing_m() / h)), 1, 6);
    const NodeField weights = FacetTable::corners(parts);

    // Adjacent facets share the places on their common edge, except at creases.
    std::vector<Point> places;
    std::vector<std::size_t> place_of;
    std::map<std::array<long long, 6>, std::size_t> known;
    for (Eigen::Index f = 0; f < surface.facets().rows(); ++f)
        for (const auto& weight : weights.rowwise()) {
            const Eigen::Vector3d inside = (1 - into_facet) * weight.transpose() + Eigen::Vector3d::Constant(into_facet / 3);
            const FreeSurface::Place corner = surface.place(f, weight.transpose());
            std::array<long long, 6> key;
            for (int d = 0; d < 3; ++d) {
                key[static_cast<std::size_t>(d)] = std::llround(corner.point_m[d] / (1e-6 * h));
                key[static_cast<std::size_t>(3 + d)] = std::llround(corner.inward[d] / 1e-3);
            }
            const auto [found, is_new] = known.emplace(key, places.size());
            if (is_new) places.push_back(surface.at(f, inside));
            place_of.push_back(found->second);
        }

    const std::array<Eigen::Vector3d, 4> shifts = {Eigen::Vector3d(0, 0, 0), {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}};
    const auto K = static_cast<std::size_t>(radii_m.size());
    std::array<Stiffnesses, 4> stiffness;
    parallel_for(4, std::min(threads, at_once), [&](int i) {
        const auto n = static_cast<std::size_t>(i);
        if (i == 0) {
            stiffness[n] = stiffness_at(mesh, energy_model_on(mesh), places, radii_m);
            return;
        }
        stiffness[n].assign(K, std::vector<std::optional<Stiffness>>(places.size()));
        try {
            const SpringMesh shifted = shifted_lattice(shape, h, shifts[n]);
            stiffness[n] = stiffness_at(shifted, energy_model_on(shifted), places, radii_m);
        // shifted lattice too coarse for the solid or its inclusion: no correction
        } catch (const Error&) {
        }
    });

    std::vector<FacetTable> tables(K, FacetTable{NodeField::Zero(mesh.facets.rows(), weights.rows())});
    for (std::size_t k = 0; k < K; ++k)
        for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
            const Eigen::Index free = surface.free_of()[static_cast<std::size_t>(f)];
            for (Eigen::Index v = 0; free >= 0 && v < weights.rows(); ++v) {
                const std::size_t p = place_of[static_cast<std::size_t>(free * weights.rows() + v)];
                if (!std::all_of(stiffness.begin(), stiffness.end(), [&](const auto& of) { return of[k][p].has_value(); })) continue;
                const Stiffness& own = *stiffness[0][k][p];
                const double mean = (own.log + stiffness[1][k][p]->log + stiffness[2][k][p]->log + stiffness[3][k][p]->log) / 4;
                tables[k].value(f, v) = std::clamp((mean - own.log) / own.by_x, -most, most);
            }
        }
    return tables;
}

}  // namespace tissue
