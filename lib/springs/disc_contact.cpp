#include "springs/disc_contact.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "error.h"
#include "mesh/facet.h"
#include "mesh/topology.h"
#include "springs/contact_errors.h"
#include "springs/contact_patch.h"

namespace tissue {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double imprint = 2.5;             // its reach, and the skin's, in radii
constexpr double under = 1.2, stuck = 4;    // how far the disc itself holds the tissue, in radii, and how much more stiffly
constexpr double reach = 1.6, shape_reach = 2;  // of the mean's weights, in spacings: at least four nodes of a square lattice
constexpr double farther = 1.25 * 1.25;  // where too few are there; a place that needs still more looks at the whole surface

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
        const double depth = std::max(0.0, ray.dot(inward)), away = squared + ray.squaredNorm();
        sum += ground_(g, 3) * depth * depth / (away * away * away);
    }
    return 8 * radius_m_ / (pi * pi) * sum;
}

double DiscContact::curved_at(const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward) const noexcept {
    return curved_among(surface_.nodes(), std::numeric_limits<double>::infinity(), contact_m, inward);
}

/// nodes: all that are within so far of the contact at least; where the fit needs farther ones, all of the surface.
double DiscContact::curved_among(const std::vector<int>& nodes, double within_m, const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward) const noexcept {
    using Terms = Eigen::Matrix<double, 6, 1>;
    constexpr int enough = 8;  // six numbers of the surface, and two to even out
    const Eigen::Matrix<double, 3, 2> tangents = tangents_of(inward);
    const Point in = inward;
    Eigen::Matrix<double, 6, 6> moments;
    Terms below;
    double reach_m = curved_reach * surface_.spacing_m();
    for (int tries = 0, found = 0; tries < 10 && found < enough; ++tries, reach_m *= 1.15) {
        moments.setZero();
        below.setZero();
        found = 0;
        for (int node : reach_m <= within_m ? nodes : surface_.nodes()) {
            const Eigen::Vector3d from = rest_.row(node).transpose() - contact_m;
            const double weight = 1 - from.squaredNorm() / (reach_m * reach_m);
            if (!(weight > 0) || !surface_.faces(node, in)) continue;
            ++found;
            const Eigen::Vector2d along = tangents.transpose() * from / radius_m_;
            const Terms terms = (Terms() << 1, along[0], along[1], along[0] * along[0] / 2, along[0] * along[1], along[1] * along[1] / 2).finished();
            moments += weight * weight * terms * terms.transpose();
            below += weight * weight * from.dot(inward) / radius_m_ * terms;
        }
    }
    // nodes on one line leave a bend open: none, then
    moments.diagonal().array() += 1e-10 * moments.trace();
    const Terms fitted = moments.ldlt().solve(below);
    return (fitted[3] + fitted[5]) / 2;
}

DiscContact::DiscContact(const SpringMesh& mesh, double radius_m, NodeField ground)
    : surface_(mesh), rest_(mesh.nodes), embedding_(mesh.embedding), radius_m_(radius_m), ground_(std::move(ground)), on_lattice_(on_lattice(mesh)),
      fixed_(static_cast<std::size_t>(mesh.node_count()), false) {
    if (!mesh.is_solid()) throw MismatchError("a disc needs a surface in space");
    if (!(radius_m > 0)) throw MismatchError("a disc needs a radius > 0");
    for (int node : mesh.fixed) fixed_[static_cast<std::size_t>(node)] = true;
    carried_ = Eigen::VectorXd::Ones(mesh.node_count());
    if (!on_lattice_) {
        carried_.setZero();
        const double square_m2 = surface_.spacing_m() * surface_.spacing_m();
        for (Eigen::Index f = 0; f < surface_.facets().rows(); ++f)
            for (int node : surface_.facets().row(f)) carried_[node] += surface_.measure()[f] / (3 * square_m2);
    }

    near_m_ = std::max(farther * own_reach_m(), imprint * radius_m_);
    for (Eigen::Index f = 0; f < surface_.facets().rows(); ++f) {
        const Eigen::Vector3d middle = surface_.at(f, Eigen::Vector3d::Constant(1.0 / 3));
        double size_m = 0;
        for (int node : surface_.facets().row(f)) size_m = std::max(size_m, (rest_.row(node).transpose() - middle).norm());
        near_.emplace_back();
        int in_reach = 0;
        for (int node : surface_.nodes()) {
            const double away_m = (rest_.row(node).transpose() - middle).norm();
            if (away_m < 1.000001 * (near_m_ + size_m)) near_.back().push_back(node);
            in_reach += away_m < std::max(own_reach_m(), imprint * radius_m_) + size_m;
        }
        most_nodes_ = std::max(most_nodes_, in_reach);
    }
    if (!embedding_.empty()) find_crowd(mesh);
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

double DiscContact::own_reach_m() const noexcept { return (on_lattice_ ? reach : shape_reach) * surface_.spacing_m(); }

Eigen::Matrix3d DiscContact::target_at(const Eigen::Vector3d& from_m, double away_m, const Eigen::Vector3d& normal) const noexcept {
    // how far the tissue goes along the surface where it is pushed that way: the same all round on average
    Eigen::Matrix3d target = Eigen::Matrix3d::Identity();
    if (away_m > radius_m_) {
        const Eigen::Matrix3d along = Eigen::Matrix3d::Identity() - normal * normal.transpose();
        const Eigen::Vector3d out = from_m / away_m;
        const double far = 1 - radius_m_ * radius_m_ / (away_m * away_m);
        const Eigen::Vector3d out_along = out - out.dot(normal) * normal;
        target += far / 3 * (2 * out * out_along.transpose() - along);
    }
    return profile(away_m / radius_m_) * target;
}

template <class Each>
void DiscContact::each_skin_node(const FreeSurface::Place& place, Each&& each) const noexcept {
    const Eigen::Vector3d centre = place.point_m, normal = place.inward;
    const Eigen::Matrix3d nn = normal * normal.transpose(), along = Eigen::Matrix3d::Identity() - nn;
    for (int node : near_[static_cast<std::size_t>(place.facet)]) {
        const Eigen::Vector3d from = rest_.row(node).transpose() - centre;
        const double away_m = from.norm(), x = away_m / radius_m_;
        if (x >= imprint || fixed_[static_cast<std::size_t>(node)] || !surface_.faces(node, place.inward)) continue;
        const double left = (imprint - std::max(x, 1.0)) / (imprint - 1), w = left * left, beside = std::max(0.0, x - 1) * w;
        const Eigen::Vector3d out = x > 1 ? Eigen::Vector3d(along * from / away_m) : Eigen::Vector3d(Eigen::Vector3d::Zero());
        each(SkinNode{node, 1 - w, w * target_at(from, away_m, normal),
                      {beside * nn, beside * along, beside * normal * out.transpose(), beside * out * normal.transpose()}});
    }
}

std::vector<SkinNode> DiscContact::skin_at(const Point& contact_m) const {
    std::vector<SkinNode> nodes;
    each_skin_node(surface_.nearest(contact_m), [&](const SkinNode& at) { nodes.push_back(at); });
    return nodes;
}

void DiscContact::show_skin(int facet, const Eigen::Vector3d& weight, const SkinLaw& skin, const Point& push_m, NodeColumns& u) const noexcept {
    const Eigen::Index free = surface_.free_of()[static_cast<std::size_t>(facet)];
    if (free < 0) return;
    each_skin_node(surface_.place(free, weight), [&](const SkinNode& at) {
        u.row(at.node) = at.shown(u.row(at.node).transpose(), skin, push_m).transpose();
    });
}

double DiscContact::crowd_of(const Node* nodes, std::size_t count) const noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += nodes[i].mean * crowd_[nodes[i].node];
    return sum;
}

/// `crowd` of an embedded solid at every node of its surface.
void DiscContact::find_crowd(const SpringMesh& mesh) {
    const double whole_m3 = std::pow(embedding_.spacing_m, 3);
    Eigen::VectorXd crowd = Eigen::VectorXd::Zero(mesh.node_count());
    std::vector<Node> near(surface_.nodes().size());
    std::vector<bool> done(static_cast<std::size_t>(mesh.node_count()), false);
    for (Eigen::Index f = 0; f < surface_.facets().rows(); ++f)
        for (int c = 0; c < 3; ++c) {
            const int node = surface_.facets()(f, c);
            if (done[static_cast<std::size_t>(node)]) continue;
            done[static_cast<std::size_t>(node)] = true;
            const Disc disc = disc_at(surface_.place(f, Eigen::Vector3d::Unit(c)), near.data(), near.size());
            std::map<int, double> weight;
            for (std::size_t i = 0; i < disc.nodes; ++i)
                for (int k = 0; k < 8; ++k) weight[embedding_.corner(near[i].node, k)] += near[i].mean * embedding_.weight(near[i].node, k);
            double sum = 0;
            for (const auto& [corner, w] : weight) sum += w * w * whole_m3 / mesh.node_measure[corner];
            crowd[node] = sum > 0 ? std::log(8 * sum) : 0;
        }
    crowd_ = crowd;
}

DiscContact::Disc DiscContact::disc_at(const FreeSurface::Place& place, Node* nodes, std::size_t room) const noexcept {
    const Eigen::Vector3d centre = place.point_m, normal = place.inward;
    const Eigen::Matrix<double, 3, 2> tangents = tangents_of(normal);
    const double h = surface_.spacing_m(), imprint_m = imprint * radius_m_;
    Disc disc{normal, {}, 0, 0};

    // nodes of the mean, and of the imprint; both from what faces the disc. Where the surface's mesh is so coarse there that
    // fewer than four are near, the mean reaches farther.
    double reach_m = own_reach_m();
    for (int tries = 0; tries < 10; ++tries, reach_m *= 1.25) {
        disc.nodes = 0;
        int in_reach = 0;
        const double most_m = std::max(reach_m, imprint_m);
        const std::vector<int>& candidates = most_m <= near_m_ ? near_[static_cast<std::size_t>(place.facet)] : surface_.nodes();
        for (int node : candidates) {
            const double* x = &rest_(node, 0);
            const double r = Eigen::Vector3d(x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]).norm();
            if (r >= most_m || !surface_.faces(node, place.inward)) continue;
            in_reach += r < 0.95 * reach_m;
            if (disc.nodes < room) {
                nodes[disc.nodes].node = node;
                nodes[disc.nodes++].away_m = r;
                continue;
            }
            Node* farthest = std::max_element(nodes, nodes + room, [](const Node& a, const Node& b) { return a.away_m < b.away_m; });
            if (r < farthest->away_m) {
                farthest->node = node;
                farthest->away_m = r;
            }
        }
        if (in_reach >= 4) break;
    }
    if (disc.nodes < 3) {
        disc.nodes = 0;
        return disc;
    }

    // moving least squares in the tangent plane, lengths in spacings
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    const auto basis = [&](const Node& at) {
        const Eigen::Vector2d across = tangents.transpose() * (rest_.row(at.node).transpose() - centre) / h;
        return Eigen::Vector3d(1, across[0], across[1]);
    };
    for (Node* at = nodes; at != nodes + disc.nodes; ++at) {
        const double weight = carried_[at->node] * bell(at->away_m / reach_m);
        if (weight > 0) moments += weight * basis(*at) * basis(*at).transpose();
    }
    const Eigen::Vector3d solved = moments.ldlt().solve(Eigen::Vector3d::UnitX());
    double crowd = 0, counted = 0, carried = 0;
    for (Node* at = nodes; at != nodes + disc.nodes; ++at) {
        const double r = at->away_m, x = r / (width * h);
        const double bare = r < reach_m ? bell(r / reach_m) : 0;
        counted += bare;
        carried += carried_[at->node] * bare;
        at->mean = carried_[at->node] * bare * basis(*at).dot(solved);
        crowd += carried_[at->node] * std::exp(-x * x / 2) / (2 * pi * width * width);
        at->pressed = r < imprint_m;
        if (!at->pressed) continue;
        at->target = target_at(rest_.row(at->node).transpose() - centre, r, normal);
        at->share = carried_[at->node] * (bell(r / imprint_m) + stuck * bell(r / (under * radius_m_)));
    }
    for (std::size_t i = 0; i < disc.nodes; ++i) disc.log_scale += nodes[i].mean * log_scale_of(nodes[i].node);
    const double phase = (crowd - 1) / (4 * std::exp(-2 * pi * pi * width * width));
    disc.factors.resize(on_lattice_ ? PatchLaw::factors : PatchLaw::shape_factors);
    disc.factors.head<PatchLaw::factors>() << 1, phase, ground_at(centre, normal), std::exp(-surface_.to_crease_m(place.point_m) / h);
    if (!on_lattice_)
        disc.factors.tail<2>() << curved_among(near_[static_cast<std::size_t>(place.facet)], near_m_, centre, normal), crowd_.size() == 0 ? std::log(counted / carried) : crowd_of(nodes, disc.nodes);
    return disc;
}

ContactRows DiscContact::rows_at(const Point& contact_m) const {
    const FreeSurface::Place place = surface_.nearest(contact_m);
    std::vector<Node> near(surface_.nodes().size());
    const Disc disc = disc_at(place, near.data(), near.size());
    near.resize(disc.nodes);
    if (near.empty()) throw NoContactError("the surface's mesh has no nodes near the contact");

    const auto K = static_cast<Eigen::Index>(near.size());
    const Eigen::Index R = 3 + 3 * std::count_if(near.begin(), near.end(), [](const Node& at) { return at.pressed; });
    ContactRows rows;
    rows.push.setZero(R, 3);
    rows.pull.setZero(R, 3 * K);
    rows.share.setOnes(R);
    rows.factors = disc.factors;
    rows.log_scale = disc.log_scale;
    rows.mean.resize(K);
    for (Eigen::Index i = 0; i < K; ++i) rows.mean[i] = near[static_cast<std::size_t>(i)].mean;
    Eigen::Matrix3d axes;
    axes << disc.normal, tangents_of(disc.normal);
    rows.push.topRows<3>() = axes.transpose();
    rows.law_row = {0, 1, 1};
    Eigen::Index row = 3;
    for (Eigen::Index i = 0; i < K; ++i) {
        const Node& at = near[static_cast<std::size_t>(i)];
        rows.nodes.push_back(at.node);
        rows.pull.block<3, 3>(0, 3 * i) = at.mean * axes.transpose();
        if (!at.pressed) continue;
        rows.push.middleRows<3>(row) = axes.transpose() * at.target;
        rows.pull.block<3, 3>(row, 3 * i) = axes.transpose();
        rows.share.segment<3>(row).setConstant(at.share);
        rows.law_row.insert(rows.law_row.end(), {2, 3, 3});
        row += 3;
    }
    rows.surface_nodes = rows.nodes;
    return embedding_.empty() ? rows : on_lattice_nodes(std::move(rows), embedding_);
}

ContactRows on_lattice_nodes(ContactRows rows, const Embedding& embedding) {
    std::map<int, Eigen::Index> column;
    for (int node : rows.nodes)
        for (int corner : embedding.corner.row(node)) column.emplace(corner, 0);
    std::vector<int> nodes;
    for (auto& [corner, at] : column) {
        at = static_cast<Eigen::Index>(nodes.size());
        nodes.push_back(corner);
    }
    Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(rows.pull.rows(), 3 * static_cast<Eigen::Index>(nodes.size()));
    for (std::size_t i = 0; i < rows.nodes.size(); ++i)
        for (int k = 0; k < 8; ++k)
            pull.middleCols(3 * column.at(embedding.corner(rows.nodes[i], k)), 3) +=
                embedding.weight(rows.nodes[i], k) * rows.pull.middleCols(3 * static_cast<Eigen::Index>(i), 3);
    rows.pull = std::move(pull);
    rows.nodes = std::move(nodes);
    return rows;
}

void DiscContact::tool_at(int facet, const Eigen::Vector3d& weight, const PatchLaw& law, ToolSpring& tool) const noexcept {
    const Eigen::Index free = surface_.free_of()[static_cast<std::size_t>(facet)];
    const Wall& wall = walls_[static_cast<std::size_t>(facet)];
    Node nodes[ToolSpring::most_nodes];
    const Disc disc = disc_at(free >= 0 ? surface_.place(free, weight) : surface_.place(wall.facet, wall.weight), nodes, ToolSpring::most_nodes);
    double k[PatchLaw::disc_rows] = {};
    for (Eigen::Index m = 0; m < std::min<Eigen::Index>(PatchLaw::disc_rows, law.log_N_m.rows()); ++m) k[m] = std::exp(law.log_N_m.row(m).transpose().dot(disc.factors)) * PatchLaw::scaled(m, std::exp(disc.log_scale));
    const Eigen::Matrix3d nn = disc.normal * disc.normal.transpose(), along = Eigen::Matrix3d::Identity() - nn;
    Eigen::Matrix3d stiffness = k[0] * nn + k[1] * along;
    if (free < 0 || disc.nodes == 0) {
        // the tool meets nothing that gives way: as stiff as where all nodes stand still
        for (std::size_t i = 0; i < disc.nodes; ++i)
            if (nodes[i].pressed) stiffness += nodes[i].share * nodes[i].target.transpose() * (k[2] * nn + k[3] * along) * nodes[i].target;
        const double size_N_m = disc.normal.dot(stiffness * disc.normal);
        stiffness = size_N_m * Eigen::Matrix3d::Identity();
        tool.begin(3, free < 0 ? wall.inward : disc.normal);
        tool.add_group(Eigen::Matrix3d::Identity(), stiffness);
        return;
    }
    tool.begin(3, disc.normal);
    const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
    tool.add_group(identity, stiffness);
    for (std::size_t i = 0; i < disc.nodes; ++i)
        if (nodes[i].mean != 0) tool.add_node(nodes[i].node, nodes[i].mean);
    for (std::size_t i = 0; i < disc.nodes; ++i) {
        if (!nodes[i].pressed) continue;
        const Eigen::Matrix3d held = nodes[i].share * (k[2] * nn + k[3] * along);
        tool.add_group(nodes[i].target, held);
        tool.add_node(nodes[i].node, 1);
    }
    if (!law.hardens()) return;
    const double hardening = k[PatchLaw::hardening_row];
    tool.harden(law.softens ? -hardening : hardening, law.softens ? hardening : k[PatchLaw::saturation_row], k[PatchLaw::coupling_row]);
}

}  // namespace tissue
