#include "springs/disc_contact.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "error.h"
#include "mesh/topology.h"
#include "springs/contact_patch.h"

namespace tissue {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double imprint = 2.5;             // its reach, in radii
constexpr double under = 1.2, stuck = 4;    // how far the disc itself holds the tissue, in radii, and how much more stiffly
constexpr double reach = 1.6, shape_reach = 2;  // of the mean's weights, in spacings: at least four nodes of a square lattice

constexpr double curved_reach = 2.2;  // of the nodes that say how curved the surface is, in spacings
constexpr double width = 0.35;  // of the bells whose sum says where between the nodes a contact stands, in spacings

/// (1 - x^2)^2, nothing beyond 1.
double bell(double x) {
    const double fall = std::max(0.0, 1 - x * x);
    return fall * fall;
}

/// Two unit vectors across a unit vector: the first as near to the first axis as can be.
Eigen::Matrix<double, 3, 2> tangents_of(const Eigen::Vector3d& normal) {
    Eigen::Index least = 0;
    normal.cwiseAbs().minCoeff(&least);
    if (std::abs(normal[0]) < 0.9) least = 0;
    Eigen::Matrix<double, 3, 2> t;
    t.col(0) = (Eigen::Vector3d::Unit(least) - normal[least] * normal).normalized();
    t.col(1) = normal.cross(Eigen::Vector3d(t.col(0)));
    return t;
}

}  // namespace

double DiscContact::profile(double x) {
    if (x <= 1) return 1 - x * x / 2;
    return ((2 - x * x) * std::asin(1 / x) + std::sqrt(x * x - 1)) / pi;
}

double DiscContact::ground_at(const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward) const {
    const double squared = radius_m_ * radius_m_;
    double sum = 0;
    for (Eigen::Index g = 0; g < ground_.rows(); ++g) {
        const Eigen::Vector3d ray = ground_.row(g).head<3>().transpose() - contact_m;
        const double depth = std::max(0.0, ray.dot(inward));
        sum += ground_(g, 3) * depth * depth / std::pow(squared + ray.squaredNorm(), 3);
    }
    return 8 * radius_m_ / (pi * pi) * sum;
}

double DiscContact::curved_at(const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward) const {
    const Eigen::Matrix<double, 3, 2> tangents = tangents_of(inward);
    constexpr std::size_t enough = 8;  // six numbers of the surface, and two to even out
    std::vector<int> near;
    double reach_m = curved_reach * surface_.spacing_m();
    for (int tries = 0; tries < 10 && near.size() < enough; ++tries, reach_m *= 1.15) {
        near.clear();
        for (int node : surface_.nodes())
            if ((rest_.row(node).transpose() - contact_m).norm() < reach_m && surface_.faces(node, inward)) near.push_back(node);
        if (near.size() >= enough) break;
    }
    Eigen::MatrixXd terms(static_cast<Eigen::Index>(near.size()), 6);
    Eigen::VectorXd below(terms.rows());
    for (Eigen::Index i = 0; i < terms.rows(); ++i) {
        const Eigen::Vector3d from = rest_.row(near[static_cast<std::size_t>(i)]).transpose() - contact_m;
        const Eigen::Vector2d along = tangents.transpose() * from / radius_m_;
        const double weight = 1 - from.squaredNorm() / (reach_m * reach_m);
        terms.row(i) << 1, along[0], along[1], along[0] * along[0] / 2, along[0] * along[1], along[1] * along[1] / 2;
        terms.row(i) *= weight;
        below[i] = weight * from.dot(inward) / radius_m_;
    }
    const Eigen::VectorXd fitted = terms.completeOrthogonalDecomposition().solve(below);
    return (fitted[3] + fitted[5]) / 2;
}

DiscContact::DiscContact(const SpringMesh& mesh, double radius_m, NodeField ground)
    : surface_(mesh), rest_(mesh.nodes), radius_m_(radius_m), ground_(std::move(ground)), on_lattice_(on_lattice(mesh)) {
    if (!mesh.is_solid()) throw MismatchError("a disc needs a surface in space");
    if (!(radius_m > 0)) throw MismatchError("a disc needs a radius > 0");
    carried_ = Eigen::VectorXd::Ones(mesh.node_count());
    if (on_lattice_) return;
    carried_.setZero();
    const double square_m2 = surface_.spacing_m() * surface_.spacing_m();
    for (Eigen::Index f = 0; f < surface_.facets().rows(); ++f)
        for (int node : surface_.facets().row(f)) carried_[node] += surface_.measure()[f] / (3 * square_m2);
}

ContactRows DiscContact::rows_at(const Point& contact_m) const {
    const FreeSurface::Place place = surface_.nearest(contact_m);
    const Eigen::Vector3d centre = place.point_m, normal = place.inward;
    const Eigen::Matrix<double, 3, 2> tangents = tangents_of(normal);
    const double h = surface_.spacing_m(), imprint_m = imprint * radius_m_;

    // nodes of the mean, and of the imprint; both from what faces the disc. Where the surface's mesh is so coarse there that
    // fewer than four are near, the mean reaches farther.
    std::vector<int> near;
    const auto away_m = [&](int node) { return (rest_.row(node).transpose() - centre).norm(); };
    double reach_m = (on_lattice_ ? reach : shape_reach) * h;
    for (int tries = 0; tries < 10; ++tries, reach_m *= 1.25) {
        near.clear();
        int in_reach = 0;
        for (int node : surface_.nodes()) {
            const double r = away_m(node);
            if (r >= std::max(reach_m, imprint_m) || !surface_.faces(node, normal)) continue;
            near.push_back(node);
            in_reach += r < 0.95 * reach_m;
        }
        if (in_reach >= 4) break;
    }
    if (near.size() < 3) throw MismatchError("the surface's mesh has no nodes near the contact");

    // moving least squares in the tangent plane, lengths in spacings
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    const auto basis = [&](int node) {
        const Eigen::Vector2d across = tangents.transpose() * (rest_.row(node).transpose() - centre) / h;
        return Eigen::Vector3d(1, across[0], across[1]);
    };
    const auto weight = [&](int node) { return carried_[node] * bell(away_m(node) / reach_m); };
    for (int node : near) moments += weight(node) * basis(node) * basis(node).transpose();
    const Eigen::Vector3d solved = moments.ldlt().solve(Eigen::Vector3d::UnitX());

    std::vector<int> pressed;
    for (int node : near)
        if (away_m(node) < imprint_m) pressed.push_back(node);
    ContactRows rows;
    const auto K = static_cast<Eigen::Index>(near.size()), R = static_cast<Eigen::Index>(3 + 3 * pressed.size());
    rows.nodes = near;
    rows.push.setZero(R, 3);
    rows.pull.setZero(R, 3 * K);
    rows.share.setOnes(R);
    Eigen::Matrix3d axes;
    axes << normal, tangents;
    for (int a = 0; a < 3; ++a) {
        rows.push.row(a) = axes.col(a).transpose();
        for (Eigen::Index i = 0; i < K; ++i) {
            const int node = near[static_cast<std::size_t>(i)];
            rows.pull.block<1, 3>(a, 3 * i) = weight(node) * basis(node).dot(solved) * axes.col(a).transpose();
        }
        rows.law_row.push_back(a == 0 ? 0 : 1);
    }
    Eigen::Index row = 3;
    for (int node : pressed) {
        const double r = away_m(node);
        const Eigen::Index i = std::find(near.begin(), near.end(), node) - near.begin();
        // how far the tissue goes along the surface where it is pushed that way: the same all round on average
        const Eigen::Vector3d out = (rest_.row(node).transpose() - centre) / std::max(r, 1e-9 * radius_m_);
        const double far = r > radius_m_ ? 1 - radius_m_ * radius_m_ / (r * r) : 0;
        Eigen::Matrix3d follows = Eigen::Matrix3d::Identity();
        follows += far * ((2 * out * out.transpose() - Eigen::Matrix3d::Identity()) / 3) *
                   (Eigen::Matrix3d::Identity() - normal * normal.transpose());
        for (int a = 0; a < 3; ++a, ++row) {
            rows.push.row(row) = profile(r / radius_m_) * axes.col(a).transpose() * follows;
            rows.pull.block<1, 3>(row, 3 * i) = axes.col(a).transpose();
            rows.share[row] = carried_[node] * (bell(r / imprint_m) + stuck * bell(r / (under * radius_m_)));
            rows.law_row.push_back(a == 0 ? 2 : 3);
        }
    }
    double crowd = 0;
    for (int node : near) crowd += carried_[node] * std::exp(-std::pow(away_m(node) / (width * h), 2) / 2) / (2 * pi * width * width);
    const double phase = (crowd - 1) / (4 * std::exp(-2 * pi * pi * width * width));
    rows.factors.resize(on_lattice_ ? PatchLaw::factors : PatchLaw::shape_factors);
    rows.factors.head<PatchLaw::factors>() << 1, phase, ground_at(centre, normal), std::exp(-surface_.to_crease_m(place.point_m) / h);
    if (on_lattice_) return rows;
    double nodes = 0, carried = 0;
    for (int node : near) {
        nodes += bell(away_m(node) / reach_m);
        carried += weight(node);
    }
    rows.factors.tail<2>() << curved_at(centre, normal), std::log(nodes / carried);
    return rows;
}

}  // namespace tissue
