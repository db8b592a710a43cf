#include "springs/disc_contact.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "error.h"
#include "mesh/facet.h"
#include "springs/contact_errors.h"
#include "springs/contact_patch.h"

namespace tissue {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double imprint = 2.5;             // reach of the imprint and of the skin, in radii
// radius around the place within which the quadric is fitted to nodes, in spacings
constexpr double curved_reach = 2.2;

/// Two unit vectors normal to a unit vector. The first is as close to the x axis as possible, or to another axis if the
/// normal is near x.
Eigen::Matrix<double, 3, 2> tangents_of(const Eigen::Vector3d& normal) {
    Eigen::Index least = 0;
    normal.cwiseAbs().minCoeff(&least);
    if (std::abs(normal[0]) < 0.9) least = 0;
    Eigen::Matrix<double, 3, 2> t;
    t.col(0) = (Eigen::Vector3d::Unit(least) - normal[least] * normal).normalized();
    t.col(1) = normal.cross(Eigen::Vector3d(t.col(0)));
    return t;
}

/// Displacement of a half space's surface per d, at from_m off the contact's centre. It is phi(r / R), and for a
/// tangential d outside the disc it is larger ahead and behind than at the sides.
Eigen::Matrix3d target_at(const Eigen::Vector3d& from_m, double away_m, double radius_m, const Eigen::Vector3d& normal) noexcept {
    // Tangential displacement by direction; its mean over all directions is 1.
    Eigen::Matrix3d target = Eigen::Matrix3d::Identity();
    if (away_m > radius_m) {
        const Eigen::Matrix3d along = Eigen::Matrix3d::Identity() - normal * normal.transpose();
        const Eigen::Vector3d out = from_m / away_m;
        const double far = 1 - radius_m * radius_m / (away_m * away_m);
        const Eigen::Vector3d out_along = out - out.dot(normal) * normal;
        target += far / 3 * (2 * out * out_along.transpose() - along);
    }
    return disc_profile(away_m / radius_m) * target;
}

/// The same for a contact that is bound within the radius (a ball's).
Eigen::Matrix3d bound_target_at(const Eigen::Vector3d& from_m, double away_m, double radius_m, const Eigen::Vector3d& normal) noexcept {
    const double x = away_m / radius_m, tapered = disc_profile(x);
    const Eigen::Matrix3d nn = normal * normal.transpose();
    return tapered * nn + bound_profile(x) / tapered * (target_at(from_m, away_m, radius_m, normal) - tapered * nn);
}

// The tangential mean row of a bound contact has weights of sum 1. Its gap is written as 5/4 (d - mean u) with the
// weights of sum 5/4, so that both directions share one set of weights.
constexpr double bound_push = PolarPoints::total, bound_stiffness = 15.0 / 8 / (bound_push * bound_push);

}  // namespace

double DiscContact::ground_at(const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward, double radius_m) const noexcept {
    const double squared = radius_m * radius_m;
    double sum = 0;
    for (Eigen::Index g = 0; g < tables_.ground.rows(); ++g) {
        const Eigen::Vector3d ray = tables_.ground.row(g).head<3>().transpose() - contact_m;
        const double depth = std::max(0.0, ray.dot(inward)), away = squared + ray.squaredNorm();
        sum += tables_.ground(g, 3) * depth * depth / (away * away * away);
    }
    return 8 * radius_m / (pi * pi) * sum;
}

double DiscContact::near_m(double radius_m) const noexcept { return std::max({curved_reach * surface_.spacing_m(), imprint * radius_m, polar_->mean_m(radius_m)}); }

SurfaceQuadric DiscContact::quadric_at(const FreeSurface::Place& place, double radius_m) const noexcept {
    const Eigen::Vector3d contact_m = place.point_m, inward = place.inward;
    using Terms = Eigen::Matrix<double, 6, 1>;
    constexpr int enough = 8;  // six coefficients of the quadric, and two more nodes to average
    const Eigen::Matrix<double, 3, 2> tangents = polar_->tangents(inward);
    const double near = near_m(radius_m);
    const std::vector<int>& nodes = near_[static_cast<std::size_t>(place.facet)];
    Eigen::Matrix<double, 6, 6> moments;
    Terms below;
    double reach_m = near;
    for (int tries = 0, found = 0; tries < 10 && found < enough; ++tries, reach_m *= 1.15) {
        moments.setZero();
        below.setZero();
        found = 0;
        // nodes near the place; all surface nodes if the fit has to reach farther
        for (int node : reach_m <= near ? nodes : surface_.nodes()) {
            const Eigen::Vector3d from = rest_.row(node).transpose() - contact_m;
            const double weight = 1 - from.squaredNorm() / (reach_m * reach_m);
            if (!(weight > 0) || !surface_.faces(node, place.inward)) continue;
            ++found;
            const Eigen::Vector2d along = tangents.transpose() * from / radius_m;
            const Terms terms = (Terms() << 1, along[0], along[1], along[0] * along[0] / 2, along[0] * along[1], along[1] * along[1] / 2).finished();
            moments += weight * weight * terms * terms.transpose();
            below += weight * weight * from.dot(inward) / radius_m * terms;
        }
    }
    // Nodes on one line leave a curvature undetermined: this makes it 0.
    moments.diagonal().array() += 1e-10 * moments.trace();
    const Terms fitted = moments.ldlt().solve(below);
    SurfaceQuadric quadric{contact_m, inward, tangents, fitted.segment<2>(1), {}};
    quadric.bend_1_m << fitted[3], fitted[4], fitted[4], fitted[5];
    quadric.bend_1_m /= radius_m;
    return quadric;
}

DiscContact::DiscContact(const SpringMesh& mesh, double radius_m, DiscTables tables)
    : surface_(mesh), rest_(mesh.nodes), radius_m_(radius_m), tables_(std::move(tables)),
      fixed_(static_cast<std::size_t>(mesh.node_count()), false) {
    if (!mesh.is_solid()) throw MismatchError("a disc needs a surface in space");
    if (mesh.embedding.empty()) throw MismatchError("a disc needs a solid in an embedded lattice");
    if (!(radius_m > 0)) throw MismatchError("a disc needs a radius > 0");
    for (int node : mesh.fixed) fixed_[static_cast<std::size_t>(node)] = true;
    polar_ = std::make_shared<const PolarPoints>(mesh, imprint);

    const double near = near_m(std::max(radius_m_, tables_.ball_contact_m));
    for (Eigen::Index f = 0; f < surface_.facets().rows(); ++f) {
        const Eigen::Vector3d middle = surface_.at(f, Eigen::Vector3d::Constant(1.0 / 3));
        double size_m = 0;
        for (int node : surface_.facets().row(f)) size_m = std::max(size_m, (rest_.row(node).transpose() - middle).norm());
        near_.emplace_back();
        for (int node : surface_.nodes())
            if ((rest_.row(node).transpose() - middle).norm() < 1.000001 * (near + size_m)) near_.back().push_back(node);
    }
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        walls_.emplace_back();
        if (surface_.free_of()[static_cast<std::size_t>(f)] >= 0) continue;
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        for (int node : mesh.facets.row(f)) middle += mesh.nodes.row(node).transpose() / 3;
        Wall& wall = walls_.back();
        wall.inward = -facet_normal(mesh.nodes, mesh.facets, f);
        wall.facet = surface_.nearest(middle).facet;
        wall.weight = nearest_on_facet(rest_, surface_.facets(), wall.facet, middle).weight;
    }
}

double DiscContact::curved_of(const SurfaceQuadric& quadric, double radius_m) const noexcept {
    return std::min(std::max(radius_m * quadric.bend_1_m.trace() / 2, tables_.curved_range[0]), tables_.curved_range[1]);
}

double DiscContact::correction_at(const FreeSurface::Place& place, double radius_m) const noexcept {
    const bool is_own = radius_m == radius_m_;
    if (is_own ? tables_.correction.value.rows() == 0 : tables_.sizes.correction.empty()) return 0;
    const Eigen::Vector3d weight = nearest_on_facet(rest_, surface_.facets(), place.facet, place.point_m).weight;
    return is_own ? tables_.correction.at(surface_.facet_of(place.facet), weight) : tables_.sizes.correction_at(radius_m, surface_.facet_of(place.facet), weight);
}

FreeSurface::Place DiscContact::place_of(int facet, const Eigen::Vector3d& weight) const noexcept {
    const Eigen::Index free = surface_.free_of()[static_cast<std::size_t>(facet)];
    const Wall& wall = walls_[static_cast<std::size_t>(facet)];
    return free >= 0 ? surface_.place(free, weight) : surface_.place(wall.facet, wall.weight);
}

ContactKernel::SurfaceAt DiscContact::surface_at(int facet, const Eigen::Vector3d& weight) const noexcept {
    const FreeSurface::Place place = place_of(facet, weight);
    const bool is_free = surface_.free_of()[static_cast<std::size_t>(facet)] >= 0;
    return {is_free ? Eigen::Vector3d(place.inward) : walls_[static_cast<std::size_t>(facet)].inward, curved_of(quadric_at(place, radius_m_), radius_m_) / radius_m_};
}

template <class Each>
void DiscContact::each_skin_node(const FreeSurface::Place& place, double radius_m, Each&& each) const noexcept {
    const Eigen::Vector3d centre = place.point_m, normal = place.inward;
    const Eigen::Matrix3d nn = normal * normal.transpose(), along = Eigen::Matrix3d::Identity() - nn;
    for (int node : near_[static_cast<std::size_t>(place.facet)]) {
        const Eigen::Vector3d from = rest_.row(node).transpose() - centre;
        const double away_m = from.norm(), x = away_m / radius_m;
        if (x >= imprint || fixed_[static_cast<std::size_t>(node)] || !surface_.faces(node, place.inward)) continue;
        const double left = (imprint - std::max(x, 1.0)) / (imprint - 1), w = left * left, beside = std::max(0.0, x - 1) * w;
        const Eigen::Vector3d out = x > 1 ? Eigen::Vector3d(along * from / away_m) : Eigen::Vector3d(Eigen::Vector3d::Zero());
        each(SkinNode{node, 1 - w, w * target_at(from, away_m, radius_m, normal),
                      {beside * nn, beside * along, beside * normal * out.transpose(), beside * out * normal.transpose()}});
    }
}

std::vector<SkinNode> DiscContact::skin_at(const Point& contact_m) const {
    std::vector<SkinNode> nodes;
    each_skin_node(surface_.nearest(contact_m), radius_m_, [&](const SkinNode& at) { nodes.push_back(at); });
    return nodes;
}

void DiscContact::show_skin(int facet, const Eigen::Vector3d& weight, double radius_m, const SkinParameters& skin, const Point& push_m, NodeColumns& u) const noexcept {
    const Eigen::Index free = surface_.free_of()[static_cast<std::size_t>(facet)];
    if (free < 0) return;
    each_skin_node(surface_.place(free, weight), radius_m > 0 ? radius_m : radius_m_, [&](const SkinNode& at) {
        u.row(at.node) = at.shown(u.row(at.node).transpose(), skin, push_m).transpose();
    });
}

DiscContact::Disc DiscContact::disc_at(const FreeSurface::Place& place, double radius_m, Footing& footing) const noexcept {
    const Eigen::Vector3d centre = place.point_m, normal = place.inward;
    Disc disc{normal, {}, 0};
    const SurfaceQuadric quadric = quadric_at(place, radius_m);
    polar_->lay(quadric, radius_m, [&](const Eigen::Vector3d& from_m, double away_m) { return (is_bound() ? bound_target_at : target_at)(from_m, away_m, radius_m, normal); }, footing);
    for (int i = 0; i < footing.means; ++i) disc.log_scale += footing.weight[i] / PolarPoints::total * log_scale_of(footing.node[i]);
    disc.log_scale += correction_at(place, radius_m);
    disc.factors << 1, curved_of(quadric, radius_m), ground_at(centre, normal, radius_m), std::exp(-surface_.to_crease_m(place.point_m) / surface_.spacing_m());
    return disc;
}

ContactRows DiscContact::rows_at(const Point& contact_m) const {
    Footing footing;
    const Disc disc = disc_at(surface_.nearest(contact_m), radius_m_, footing);
    if (footing.means == 0) throw NoContactError("the lattice has no tissue near the contact");

    ContactRows rows;
    std::map<int, Eigen::Index> column;
    for (int i = 0; i < footing.entries; ++i)
        if (column.emplace(footing.node[i], static_cast<Eigen::Index>(rows.nodes.size())).second) rows.nodes.push_back(footing.node[i]);
    const auto K = static_cast<Eigen::Index>(rows.nodes.size());
    const Eigen::Index R = 3 + 3 * footing.points;
    Eigen::Matrix3d axes;
    axes << disc.normal, tangents_of(disc.normal);
    rows.push.setZero(R, 3);
    rows.pull.setZero(R, 3 * K);
    rows.share.setOnes(R);
    rows.factors = disc.factors;
    rows.log_scale = disc.log_scale;
    rows.mean.setZero(K);
    rows.push.topRows<3>() = axes.transpose();
    if (is_bound()) rows.push.middleRows<2>(1) *= bound_push, rows.share.segment<2>(1).setConstant(bound_stiffness);
    rows.parameter_row = {0, 1, 1};
    rows.touched.resize(static_cast<std::size_t>(1 + footing.points));
    for (int i = 0; i < footing.means; ++i) rows.touched[0].push_back(i);
    // the mean's nodes are the first ones
    for (int i = 0; i < footing.means; ++i) {
        rows.mean[i] = footing.weight[i] / PolarPoints::total;
        rows.pull.block<3, 3>(0, 3 * i) = footing.weight[i] * axes.transpose();
    }
    for (int p = 0; p < footing.points; ++p) {
        const Footing::Point& point = footing.point[p];
        const Eigen::Index row = 3 + 3 * p;
        rows.push.middleRows<3>(row) = axes.transpose() * point.target;
        for (int i = point.begin; i < point.end; ++i) {
            const Eigen::Index node = column.at(footing.node[i]);
            rows.pull.block<3, 3>(row, 3 * node) += footing.weight[i] * axes.transpose();
            rows.touched[static_cast<std::size_t>(1 + p)].push_back(static_cast<int>(node));
        }
        rows.share.segment<3>(row).setConstant(point.share);
        rows.parameter_row.insert(rows.parameter_row.end(), {2, 3, 3});
    }
    return rows;
}

void DiscContact::tool_at(int facet, const Eigen::Vector3d& weight, double radius_m, const ContactParameters& contact_parameters, ToolSpring& tool) const noexcept {
    const bool is_free = surface_.free_of()[static_cast<std::size_t>(facet)] >= 0;
    Footing footing;
    const Disc disc = disc_at(place_of(facet, weight), radius_m > 0 ? radius_m : radius_m_, footing);
    double k[ContactParameters::disc_rows] = {};
    for (Eigen::Index m = 0; m < std::min<Eigen::Index>(ContactParameters::disc_rows, contact_parameters.log_N_m.rows()); ++m) k[m] = std::exp(contact_parameters.log_N_m.row(m).transpose().dot(disc.factors)) * ContactParameters::scaled(m, std::exp(disc.log_scale));
    const Eigen::Matrix3d nn = disc.normal * disc.normal.transpose(), along = Eigen::Matrix3d::Identity() - nn;
    if (is_bound()) k[1] *= bound_stiffness;
    Eigen::Matrix3d stiffness = k[0] * nn + k[1] * along;
    if (!is_free || footing.means == 0) {
        // The tool meets a fixed wall: its stiffness is that of the contact at fixed nodes.
        for (const Footing::Point* at = footing.point; at != footing.point + footing.points; ++at) stiffness += at->share * at->target.transpose() * (k[2] * nn + k[3] * along) * at->target;
        const double size_N_m = disc.normal.dot(stiffness * disc.normal);
        stiffness = size_N_m * Eigen::Matrix3d::Identity();
        tool.begin(3, is_free ? disc.normal : walls_[static_cast<std::size_t>(facet)].inward);
        tool.add_group(Eigen::Matrix3d::Identity(), stiffness);
        return;
    }
    tool.begin(3, disc.normal);
    const Eigen::Matrix3d target = is_bound() ? Eigen::Matrix3d(nn + bound_push * along) : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    tool.add_group(target, stiffness);
    for (int i = 0; i < footing.means; ++i)
        if (footing.weight[i] != 0) tool.add_node(footing.node[i], footing.weight[i]);
    for (const Footing::Point* at = footing.point; at != footing.point + footing.points; ++at) {
        tool.add_group(at->target, at->share * (k[2] * nn + k[3] * along));
        for (int i = at->begin; i < at->end; ++i) tool.add_node(footing.node[i], footing.weight[i]);
    }
    if (!contact_parameters.hardens()) return;
    const double hardening = k[ContactParameters::hardening_row];
    const bool softens = contact_parameters.curve == ContactCurve::softens;
    tool.harden(softens ? -hardening : hardening, softens ? hardening : k[ContactParameters::saturation_row], k[ContactParameters::coupling_row], contact_parameters.curve == ContactCurve::compression,
                contact_parameters.curve == ContactCurve::compression ? 2 * k[ContactParameters::coupling_row] / k[1] : 0);
}

}  // namespace tissue
