#include "haptic/realtime_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "error.h"
#include "haptic/hot_loop.h"
#include "springs/spring_law.h"
#include "springs/stretch.h"

namespace tissue {
namespace {

constexpr int chunk = 256;          ///< springs at a time: their forces stay in the first-level cache
constexpr double tiny_m = 1e-12;    ///< two nodes on one spot have no direction to push in

/// What a kernel sees of one run of slots: k = 0 .. n-1. d = u_j - u_i of each spring, n its axis.
struct Run {
    const double *theta, *ux_i, *uy_i, *ux_j, *uy_j;
    const double *nx, *ny, *sx, *sy, *length;
};

}  // namespace

// Force on the first node of every spring of a run, with the sign turned: g = theta * (pull of the spring).
namespace kernel {

TISSUE_HOT void isotropic(const Run& r, int n, double* __restrict gx, double* __restrict gy) {
    for (int k = 0; k < n; ++k) {
        gx[k] = r.theta[k] * (r.ux_j[k] - r.ux_i[k]);
        gy[k] = r.theta[k] * (r.uy_j[k] - r.uy_i[k]);
    }
}

TISSUE_HOT void axial(const Run& r, int n, double* __restrict gx, double* __restrict gy) {
    for (int k = 0; k < n; ++k) {
        const double pull =
            r.theta[k] * (r.nx[k] * (r.ux_j[k] - r.ux_i[k]) + r.ny[k] * (r.uy_j[k] - r.uy_i[k]));
        gx[k] = pull * r.nx[k];
        gy[k] = pull * r.ny[k];
    }
}

/// Axial springs of one direction: the axis is not read from memory, which is what large meshes wait for.
TISSUE_HOT void axial_parallel(const Run& r, int n, double nx, double ny, double* __restrict gx, double* __restrict gy) {
    for (int k = 0; k < n; ++k) {
        const double pull = r.theta[k] * (nx * (r.ux_j[k] - r.ux_i[k]) + ny * (r.uy_j[k] - r.uy_i[k]));
        gx[k] = pull * nx;
        gy[k] = pull * ny;
    }
}

template <class Stretch>
inline void turning(const Run& r, int n, double* __restrict gx, double* __restrict gy) {
    for (int k = 0; k < n; ++k) {
        const double x = r.sx[k] + (r.ux_j[k] - r.ux_i[k]), y = r.sy[k] + (r.uy_j[k] - r.uy_i[k]);
        const double pull = r.theta[k] * Stretch::secant(r.length[k], std::max(std::sqrt(x * x + y * y), tiny_m));
        gx[k] = pull * x;
        gy[k] = pull * y;
    }
}

TISSUE_HOT void geometric(const Run& r, int n, double* __restrict gx, double* __restrict gy) {
    turning<HookeanStretch>(r, n, gx, gy);
}

TISSUE_HOT void rubber(const Run& r, int n, double* __restrict gx, double* __restrict gy) {
    turning<RubberStretch>(r, n, gx, gy);
}

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
    law_ = make_spring_law(law)->name() == "isotropic" ? Law::isotropic
           : law == "axial"                            ? Law::axial
           : law == "geometric"                        ? Law::geometric
                                                       : Law::rubber;
    rest_ = mesh.nodes;
    mass_ = node_mass_kg;
    inverse_mass_ = mass_.cwiseInverse();
    for (int node : mesh.fixed) inverse_mass_[node] = 0;
    outline_ = mesh.boundary;

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

Eigen::VectorXd RealtimeMesh::to_slots(const Eigen::Ref<const Eigen::VectorXd>& theta) const {
    if (theta.size() != spring_count())
        throw MismatchError(fmt::format("a spring set of {} for a mesh of {} springs", theta.size(), spring_count()));
    Eigen::VectorXd by_slot = Eigen::VectorXd::Zero(slot_count());
    for (int s = 0; s < spring_count(); ++s) by_slot[slot_of_spring_[static_cast<std::size_t>(s)]] = theta[s];
    return by_slot;
}

void RealtimeMesh::force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f) const noexcept {
    alignas(64) double gx[chunk], gy[chunk];
    const Eigen::Index N = u.rows();
    const double *ux = u.data(), *uy = u.data() + N;
    double *fx = f.data(), *fy = f.data() + N;
    std::fill(fx, fx + 2 * N, 0.0);
    for (const Band& band : bands_)
        for (int done = 0; done < band.count; done += chunk) {
            const int n = std::min(chunk, band.count - done);
            const int i = band.first_node + done, j = i + band.offset, slot = band.first_slot + done;
            const Run run{theta.data() + slot, ux + i,          uy + i,
                          ux + j,              uy + j,          axis_.col(0).data() + slot,
                          axis_.col(1).data() + slot, rest_span_.col(0).data() + slot, rest_span_.col(1).data() + slot,
                          rest_length_.data() + slot};
            switch (law_) {
                case Law::isotropic: kernel::isotropic(run, n, gx, gy); break;
                case Law::axial:
                    if (band.parallel) kernel::axial_parallel(run, n, band.nx, band.ny, gx, gy);
                    else kernel::axial(run, n, gx, gy);
                    break;
                case Law::geometric: kernel::geometric(run, n, gx, gy); break;
                case Law::rubber: kernel::rubber(run, n, gx, gy); break;
            }
            kernel::add_pair(n, gx, fx + i, fx + j);
            kernel::add_pair(n, gy, fy + i, fy + j);
        }
    for (int slot = loose_slot_; slot < slot_count(); ++slot) {
        const int i = first_[static_cast<std::size_t>(slot)], j = second_[static_cast<std::size_t>(slot)];
        const Eigen::Vector2d d(ux[j] - ux[i], uy[j] - uy[i]), n = axis_.row(slot);
        Eigen::Vector2d g = d;
        if (law_ == Law::axial) g = n * n.dot(d);
        if (!linear()) {
            const Eigen::Vector2d now = rest_span_.row(slot).transpose() + d;
            g = now * stretched(rest_length_[slot], std::max(now.norm(), tiny_m)).secant;
        }
        g *= theta[slot];
        fx[i] -= g.x();
        fy[i] -= g.y();
        fx[j] += g.x();
        fy[j] += g.y();
    }
}

RealtimeMesh::Stretched RealtimeMesh::stretched(double rest, double length) const noexcept {
    const auto answer = [&](auto law) -> Stretched {
        return {law.secant(rest, length), law.tangent(rest, length), law.energy(rest, length)};
    };
    return law_ == Law::rubber ? answer(RubberStretch{}) : answer(HookeanStretch{});
}

double RealtimeMesh::stiffest_stretch() const noexcept {
    return law_ == Law::rubber ? RubberStretch::stiffest : HookeanStretch::stiffest;
}

double RealtimeMesh::potential_energy(const Eigen::VectorXd& theta, const NodeColumns& u) const noexcept {
    double energy = 0;
    for (int slot = 0; slot < slot_count(); ++slot) {
        const int i = first_[static_cast<std::size_t>(slot)], j = second_[static_cast<std::size_t>(slot)];
        const Eigen::Vector2d d = u.row(j) - u.row(i);
        double unit = d.squaredNorm() / 2;
        if (law_ == Law::axial) unit = std::pow(axis_.row(slot).dot(d), 2) / 2;
        if (!linear() && rest_length_[slot] > 0)
            unit = stretched(rest_length_[slot], (rest_span_.row(slot).transpose() + d).norm()).energy;
        energy += theta[slot] * unit;
    }
    return energy;
}

Eigen::Matrix2d RealtimeMesh::unit_stiffness(int slot, const NodeColumns& u, bool convex) const noexcept {
    const Eigen::Vector2d n = axis_.row(slot);
    switch (law_) {
        case Law::isotropic: return Eigen::Matrix2d::Identity();
        case Law::axial: return n * n.transpose();
        case Law::geometric:
        case Law::rubber: break;
    }
    const int i = first_[static_cast<std::size_t>(slot)], j = second_[static_cast<std::size_t>(slot)];
    const Eigen::Vector2d now = rest_span_.row(slot) + u.row(j) - u.row(i);
    const double length = now.norm();
    if (!(length > tiny_m)) return Eigen::Matrix2d::Identity();
    const Eigen::Vector2d t = now / length;
    const Stretched s = stretched(rest_length_[slot], length);
    const double across = s.secant;
    const Eigen::Matrix2d along = t * t.transpose();
    return s.tangent * along + (convex ? std::max(across, 0.0) : across) * (Eigen::Matrix2d::Identity() - along);
}

}  // namespace tissue
