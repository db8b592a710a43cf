#include "haptic/realtime_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "error.h"
#include "haptic/cell_kernels.h"

namespace tissue {
namespace {

constexpr int chunk = 256;  ///< rows, or loose springs, per pass: their forces stay in the first-level cache
constexpr int fewest = 8;   ///< smallest number of springs in a band
/// a band of an embedded lattice ends at a larger gap of empty slots: 12 cost as much as a new band
constexpr int most_empty = 12;
constexpr double same = 1e-13;  ///< relative to a spring's length: rounding of positions far from the origin

}  // namespace

RealtimeMesh::RealtimeMesh(const SpringMesh& mesh, const std::string& law, const Eigen::VectorXd& node_mass_kg) : RealtimeMesh(mesh, make_spring_law(law), node_mass_kg) {}

RealtimeMesh::RealtimeMesh(const SpringMesh& mesh, const SpringCurve& curve, const Eigen::VectorXd& node_mass_kg) : RealtimeMesh(mesh, make_turning_law(curve), node_mass_kg) {}

RealtimeMesh::RealtimeMesh(const SpringMesh& mesh, std::unique_ptr<SpringLaw> law, const Eigen::VectorXd& node_mass_kg)
    : law_(std::move(law)), embedding_(mesh.embedding), rows_(mesh) {
    const int N = mesh.node_count(), S = mesh.spring_count();
    const int own = mesh.embedding.node_count();
    if (node_mass_kg.size() != N || !(node_mass_kg.tail(N - own).minCoeff() > 0) || (own > 0 && !node_mass_kg.head(own).isZero(0)) || !node_mass_kg.allFinite())
        throw MismatchError("every node of the spring mesh must have a positive mass, and an embedded solid's own nodes must have none");
    if (mesh.is_solid() && !law_->plays_in_space())
        throw MismatchError(fmt::format("in space a session needs 'geometric' springs, not '{}'", law_->name()));
    rest_ = mesh.nodes;
    mass_ = node_mass_kg;
    inverse_mass_ = Eigen::VectorXd::Zero(N);
    inverse_mass_.tail(N - own) = mass_.tail(N - own).cwiseInverse();
    for (int node : mesh.fixed) inverse_mass_[node] = 0;
    if (!mesh.is_solid()) outline_ = mesh.loop();
    facets_ = mesh.facets;

    // A band joins rows i and i + offset. At least half of its slots have a spring, and no two springs share a slot.
    // Springs of equal span are put into bands first.
    using Span = std::array<long, 3>;
    std::map<int, std::map<Span, std::vector<std::pair<int, int>>>> by_offset;  // pairs: first row, spring
    for (int s = 0; s < S; ++s) {
        const int i = mesh.springs.row(s).minCoeff(), j = mesh.springs.row(s).maxCoeff();
        Span span{};
        for (Eigen::Index d = 0; d < rest_.cols(); ++d) span[static_cast<std::size_t>(d)] = std::lround(1e9 * (rest_(j, d) - rest_(i, d)) / mesh.rest_length(s));
        by_offset[rows_.of(j) - rows_.of(i)][span].emplace_back(rows_.of(i), s);
    }
    slot_of_spring_.assign(static_cast<std::size_t>(S), -1);
    int slots = 0;
    const int most_apart = rows_.by_node() ? rows_.count() : most_empty + 1;
    std::vector<int> loose;
    for (auto& [offset, by_span] : by_offset) {
        std::vector<std::pair<int, int>> rest;  // springs of spans too rare for a band
        const auto add_bands = [&, offset = offset](const std::vector<std::pair<int, int>>& springs, auto leave) {
            for (std::size_t begin = 0, end; begin < springs.size(); begin = end) {
                std::size_t longest = end = begin + 1;
                for (; end < springs.size() && springs[end].first > springs[end - 1].first && springs[end].first - springs[end - 1].first <= most_apart; ++end)
                    if (2 * static_cast<int>(end + 1 - begin) >= springs[end].first - springs[begin].first + 1) longest = end + 1;
                end = longest;
                const int low = springs[begin].first, span = springs[end - 1].first - low + 1;
                if (static_cast<int>(end - begin) < fewest) {
                    leave(springs[begin]);
                    end = begin + 1;
                    continue;
                }
                for (std::size_t k = begin; k < end; ++k) slot_of_spring_[static_cast<std::size_t>(springs[k].second)] = slots + springs[k].first - low;
                bands_.push_back({low, offset, slots, span, true, true, {}, {}, 0});
                slots += span;
            }
        };
        for (auto& [span, springs] : by_span) {
            std::sort(springs.begin(), springs.end());
            add_bands(springs, [&](const std::pair<int, int>& left) { rest.push_back(left); });
        }
        std::sort(rest.begin(), rest.end());
        add_bands(rest, [&](const std::pair<int, int>& left) { loose.push_back(left.second); });
    }
    loose_slot_ = slots;
    for (int s : loose) slot_of_spring_[static_cast<std::size_t>(s)] = slots++;

    first_.assign(static_cast<std::size_t>(slots), 0);
    second_.assign(static_cast<std::size_t>(slots), 0);
    axis_ = NodeColumns::Zero(slots, mesh.dimension());
    rest_span_ = NodeColumns::Zero(slots, mesh.dimension());
    rest_length_ = Eigen::VectorXd::Zero(slots);
    for (int s = 0; s < S; ++s) {
        const int slot = slot_of_spring_[static_cast<std::size_t>(s)];
        const int i = mesh.springs.row(s).minCoeff(), j = mesh.springs.row(s).maxCoeff();
        first_[static_cast<std::size_t>(slot)] = i;
        second_[static_cast<std::size_t>(slot)] = j;
        rest_span_.row(slot) = rest_.row(j) - rest_.row(i);
        rest_length_[slot] = rest_span_.row(slot).norm();
        if (!(rest_length_[slot] > 0))
            throw MismatchError(fmt::format("spring {} of the mesh has no length", s));
        axis_.row(slot) = rest_span_.row(slot) / rest_length_[slot];
    }
    for (int slot = loose_slot_; slot < slots; ++slot) {
        loose_first_.push_back(rows_.of(first_[static_cast<std::size_t>(slot)]));
        loose_second_.push_back(rows_.of(second_[static_cast<std::size_t>(slot)]));
    }
    for (Band& band : bands_) {  // the first slot of a band has a spring
        const Eigen::RowVectorXd axis = axis_.row(band.first_slot), span = rest_span_.row(band.first_slot);
        std::copy(axis.begin(), axis.end(), band.axis);
        std::copy(span.begin(), span.end(), band.span);
        band.length = rest_length_[band.first_slot];
        for (int slot = band.first_slot; slot < band.first_slot + band.count; ++slot) {
            if (rest_length_[slot] == 0) continue;
            band.parallel = band.parallel && (axis_.row(slot) - axis).norm() < same;
            band.alike = band.alike && (rest_span_.row(slot) - span).norm() < same * band.length;
        }
    }
}

Point RealtimeMesh::rest_place(int facet, const Eigen::Vector3d& weight) const noexcept {
    Point place = Point::Zero(dimension());
    for (Eigen::Index k = 0; k < facets_.cols(); ++k) place += weight[k] * rest_.row(facets_(facet, k)).transpose();
    return place;
}

Eigen::VectorXd RealtimeMesh::to_slots(const Eigen::Ref<const Eigen::VectorXd>& theta) const {
    if (theta.size() != spring_count())
        throw MismatchError(fmt::format("a spring set of {} for a mesh of {} springs", theta.size(), spring_count()));
    Eigen::VectorXd by_slot = Eigen::VectorXd::Zero(slot_count());
    for (int s = 0; s < spring_count(); ++s) by_slot[slot_of_spring_[static_cast<std::size_t>(s)]] = theta[s];
    return by_slot;
}

void RealtimeMesh::force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept {
    std::fill(f.data(), f.data() + f.size(), 0.0);
    bands_force(theta, u, f, memory);
    loose_force(theta, u, f, memory);
}

/// Arguments of the spring law for the springs from a slot on, without displacements and forces of their ends.
SpringRun RealtimeMesh::run_at(int slot, const Eigen::VectorXd& theta) const noexcept {
    SpringRun run{};
    run.dimension = dimension();
    run.theta = theta.data() + slot;
    run.length = rest_length_.data() + slot;
    for (int d = 0; d < dimension(); ++d) {
        run.axis[d] = axis_.col(d).data() + slot;
        run.span[d] = rest_span_.col(d).data() + slot;
    }
    return run;
}

/// All bands of one chunk of rows, then of the next chunk, so that the data stay in the cache. Forces on the first ends
/// are summed in an array of their own, so that no run overlaps itself.
void RealtimeMesh::bands_force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept {
    alignas(64) double own[3][chunk];
    const int D = dimension(), N = rows_.count();
    for (int first = 0; first < N && !bands_.empty(); first += chunk) {
        const int last = std::min(first + chunk, N);
        for (int d = 0; d < D; ++d) std::fill(own[d], own[d] + (last - first), 0.0);
        for (const Band& band : bands_) {
            const int i = std::max(first, band.first_row), n = std::min(last, band.first_row + band.count) - i, j = i + band.offset;
            if (n <= 0) continue;
            SpringRun run = run_at(band.first_slot + i - band.first_row, theta);
            run.memory = memory;
            run.first = band.first_slot + i - band.first_row;
            run.parallel = band.parallel;
            run.alike = band.alike;
            run.one_length = band.length;
            for (int d = 0; d < D; ++d) {
                run.one_axis[d] = band.axis[d];
                run.one_span[d] = band.span[d];
                run.u_i[d] = u.col(d).data() + i;
                run.u_j[d] = u.col(d).data() + j;
                run.f_i[d] = own[d] + (i - first);
                run.f_j[d] = f.col(d).data() + j;
            }
            law_->pull(run, n);
        }
        for (int d = 0; d < D; ++d) kernel::add(last - first, own[d], f.col(d).data() + first);
    }
}

/// The ends of loose springs are not contiguous: displacements are gathered, and forces scattered.
void RealtimeMesh::loose_force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept {
    alignas(64) double u_i[3][chunk], u_j[3][chunk], f_i[3][chunk], f_j[3][chunk];
    const int D = dimension();
    for (int first = loose_slot_; first < slot_count(); first += chunk) {
        const int n = std::min(chunk, slot_count() - first);
        const int *i = loose_first_.data() + first - loose_slot_, *j = loose_second_.data() + first - loose_slot_;
        SpringRun run = run_at(first, theta);
        run.memory = memory;
        run.first = first;
        for (int d = 0; d < D; ++d) {
            const double* from = u.col(d).data();
            for (int k = 0; k < n; ++k) {
                u_i[d][k] = from[i[k]];
                u_j[d][k] = from[j[k]];
                f_i[d][k] = f_j[d][k] = 0;
            }
            run.u_i[d] = u_i[d];
            run.u_j[d] = u_j[d];
            run.f_i[d] = f_i[d];
            run.f_j[d] = f_j[d];
        }
        law_->pull(run, n);
        for (int d = 0; d < D; ++d) {
            double* to = f.col(d).data();
            for (int k = 0; k < n; ++k) {
                to[i[k]] += f_i[d][k];
                to[j[k]] += f_j[d][k];
            }
        }
    }
}

double RealtimeMesh::potential_energy(const Eigen::VectorXd& theta, const NodeColumns& u) const noexcept {
    double energy = 0;
    for (int slot : slot_of_spring_) {
        const Eigen::Vector2i ends = nodes_of_slot(slot);
        energy += theta[slot] * law_->unit_energy(rest_span_.row(slot).transpose(), (u.row(ends[1]) - u.row(ends[0])).transpose());
    }
    return energy;
}

Eigen::Matrix2d RealtimeMesh::unit_stiffness(int slot, const NodeColumns& u, bool convex) const noexcept {
    const Eigen::Vector2i ends = nodes_of_slot(slot);
    const Eigen::Vector2d rest = rest_span_.row(slot), relative = u.row(ends[1]) - u.row(ends[0]);
    return law_->unit_stiffness(rest, relative, convex);
}

SparseMatrix RealtimeMesh::stiffness_at_rest(const Eigen::VectorXd& theta) const {
    const int D = dimension();
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(4 * D * D * spring_count()));
    for (int slot : slot_of_spring_) {
        const Eigen::Vector2i ends = nodes_of_slot(slot);
        const Point span = rest_span_.row(slot).transpose();
        Eigen::MatrixXd k;
        if (D == 2) k = law_->unit_stiffness(Eigen::Vector2d(span), Eigen::Vector2d::Zero(), false);
        else k = law_->unit_stiffness(Eigen::Vector3d(span), Eigen::Vector3d::Zero(), false);
        for (int p : {0, 1})
            for (int q : {0, 1})
                for (int a = 0; a < D; ++a)
                    for (int b = 0; b < D; ++b) entries.emplace_back(D * ends[p] + a, D * ends[q] + b, (p == q ? theta[slot] : -theta[slot]) * k(a, b));
    }
    SparseMatrix K(D * node_count(), D * node_count());
    K.setFromTriplets(entries.begin(), entries.end());
    return K;
}

}  // namespace tissue
