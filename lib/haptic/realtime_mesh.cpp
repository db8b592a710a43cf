#include "haptic/realtime_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "error.h"
#include "hot_loop.h"

namespace tissue {
namespace {

constexpr int chunk = 256;          ///< springs at a time: their forces stay in the first-level cache

}  // namespace

namespace kernel {

TISSUE_HOT void add_pair(int n, const double* __restrict g, double* f_i, double* f_j) {
    for (int k = 0; k < n; ++k) f_i[k] -= g[k];
    for (int k = 0; k < n; ++k) f_j[k] += g[k];
}

}  // namespace kernel

RealtimeMesh::RealtimeMesh(const SpringMesh& mesh, const std::string& law, const Eigen::VectorXd& node_mass_kg) {
    const int N = mesh.node_count(), S = mesh.spring_count();
    if (mesh.dimension() != 2)
        throw MismatchError(fmt::format("the realtime core is two-dimensional; this mesh has {} axes", mesh.dimension()));
    if (node_mass_kg.size() != N || !(node_mass_kg.minCoeff() > 0) || !node_mass_kg.allFinite())
        throw MismatchError("every node of the spring mesh must have a positive mass");
    law_ = make_spring_law(law);
    rest_ = mesh.nodes;
    mass_ = node_mass_kg;
    inverse_mass_ = mass_.cwiseInverse();
    for (int node : mesh.fixed) inverse_mass_[node] = 0;
    if (!mesh.is_solid()) outline_ = mesh.loop();
    facets_ = mesh.facets;

    // bands: offsets that fill at least half of the run they span
    std::map<int, std::vector<int>> by_offset;
    for (int s = 0; s < S; ++s) by_offset[std::abs(mesh.springs(s, 1) - mesh.springs(s, 0))].push_back(s);
    slot_of_spring_.assign(static_cast<std::size_t>(S), -1);
    int slots = 0;
    std::vector<int> loose;
    for (const auto& [offset, springs] : by_offset) {
        int low = N, high = -1;
        for (int s : springs) {
            low = std::min(low, mesh.springs.row(s).minCoeff());
            high = std::max(high, mesh.springs.row(s).minCoeff());
        }
        const int span = high - low + 1;
        const int before = slots;
        bool distinct = 2 * static_cast<int>(springs.size()) >= span;
        if (distinct) {
            std::vector<bool> taken(static_cast<std::size_t>(span), false);
            for (int s : springs) {
                const auto k = static_cast<std::size_t>(mesh.springs.row(s).minCoeff() - low);
                distinct = distinct && !taken[k];
                taken[k] = true;
            }
        }
        if (!distinct) {
            loose.insert(loose.end(), springs.begin(), springs.end());
            continue;
        }
        for (int s : springs)
            slot_of_spring_[static_cast<std::size_t>(s)] = before + mesh.springs.row(s).minCoeff() - low;
        bands_.push_back({low, offset, before, span, false, 0, 0});
        slots += span;
    }
    loose_slot_ = slots;
    for (int s : loose) slot_of_spring_[static_cast<std::size_t>(s)] = slots++;

    first_.assign(static_cast<std::size_t>(slots), 0);
    second_.assign(static_cast<std::size_t>(slots), 0);
    axis_ = NodeColumns::Zero(slots, 2);
    rest_span_ = NodeColumns::Zero(slots, 2);
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
    for (Band& band : bands_) {
        const Eigen::RowVector2d axis = axis_.row(band.first_slot);  // a band starts with a spring
        band.nx = axis.x();
        band.ny = axis.y();
        band.parallel = true;
        for (int slot = band.first_slot; slot < band.first_slot + band.count; ++slot)
            band.parallel = band.parallel && (rest_length_[slot] == 0 || (axis_.row(slot) - axis).norm() < 1e-14);
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

void RealtimeMesh::force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f) const noexcept {
    std::fill(f.data(), f.data() + f.size(), 0.0);
    for (const Band& band : bands_) band_force(band, theta, u, f);
    loose_force(theta, u, f);
}

/// What the law sees of the springs from one slot on, but for the displacement of their ends.
SpringRun RealtimeMesh::run_at(int slot, const Eigen::VectorXd& theta) const noexcept {
    SpringRun run{};
    run.theta = theta.data() + slot;
    run.nx = axis_.col(0).data() + slot;
    run.ny = axis_.col(1).data() + slot;
    run.sx = rest_span_.col(0).data() + slot;
    run.sy = rest_span_.col(1).data() + slot;
    run.length = rest_length_.data() + slot;
    return run;
}

void RealtimeMesh::band_force(const Band& band, const Eigen::VectorXd& theta, const NodeColumns& u,
                              NodeColumns& f) const noexcept {
    alignas(64) double gx[chunk], gy[chunk];
    const Eigen::Index N = u.rows();
    const double *ux = u.data(), *uy = u.data() + N;
    double *fx = f.data(), *fy = f.data() + N;
    for (int done = 0; done < band.count; done += chunk) {
        const int n = std::min(chunk, band.count - done);
        const int i = band.first_node + done, j = i + band.offset;
        SpringRun run = run_at(band.first_slot + done, theta);
        run.ux_i = ux + i;
        run.uy_i = uy + i;
        run.ux_j = ux + j;
        run.uy_j = uy + j;
        run.parallel = band.parallel;
        run.axis_x = band.nx;
        run.axis_y = band.ny;
        law_->pull(run, n, gx, gy);
        kernel::add_pair(n, gx, fx + i, fx + j);
        kernel::add_pair(n, gy, fy + i, fy + j);
    }
}

/// The ends of loose springs lie anywhere: they are gathered, and their forces scattered.
void RealtimeMesh::loose_force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f) const noexcept {
    alignas(64) double gx[chunk], gy[chunk], ux_i[chunk], uy_i[chunk], ux_j[chunk], uy_j[chunk];
    for (int first = loose_slot_; first < slot_count(); first += chunk) {
        const int n = std::min(chunk, slot_count() - first);
        const int *i = first_.data() + first, *j = second_.data() + first;
        for (int k = 0; k < n; ++k) {
            ux_i[k] = u(i[k], 0);
            uy_i[k] = u(i[k], 1);
            ux_j[k] = u(j[k], 0);
            uy_j[k] = u(j[k], 1);
        }
        SpringRun run = run_at(first, theta);
        run.ux_i = ux_i;
        run.uy_i = uy_i;
        run.ux_j = ux_j;
        run.uy_j = uy_j;
        law_->pull(run, n, gx, gy);
        for (int k = 0; k < n; ++k) {
            f(i[k], 0) -= gx[k];
            f(i[k], 1) -= gy[k];
            f(j[k], 0) += gx[k];
            f(j[k], 1) += gy[k];
        }
    }
}

double RealtimeMesh::potential_energy(const Eigen::VectorXd& theta, const NodeColumns& u) const noexcept {
    double energy = 0;
    for (int slot : slot_of_spring_) {
        const Eigen::Vector2i ends = nodes_of_slot(slot);
        energy += theta[slot] * law_->unit_energy(rest_span_.row(slot), u.row(ends[1]) - u.row(ends[0]));
    }
    return energy;
}

Eigen::Matrix2d RealtimeMesh::unit_stiffness(int slot, const NodeColumns& u, bool convex) const noexcept {
    const Eigen::Vector2i ends = nodes_of_slot(slot);
    return law_->unit_stiffness(rest_span_.row(slot), u.row(ends[1]) - u.row(ends[0]), convex);
}

}  // namespace tissue
