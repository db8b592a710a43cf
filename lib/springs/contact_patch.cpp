#include "springs/contact_patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace tissue {
namespace {

/// The four weights of the uniform cubic B-spline at a fraction f of the interval between its two middle nodes (de
/// Boor).
void spline_weights(double f, double (&w)[4]) noexcept {
    const double g = 1 - f;
    w[0] = g * g * g / 6;
    w[1] = (4 - 6 * f * f + 3 * f * f * f) / 6;
    w[2] = (4 - 6 * g * g + 3 * g * g * g) / 6;
    w[3] = f * f * f / 6;
}

void spline_slopes(double f, double (&w)[4]) noexcept {
    const double g = 1 - f;
    w[0] = -g * g / 2;
    w[1] = -2 * f + 1.5 * f * f;
    w[2] = 2 * g - 1.5 * g * g;
    w[3] = f * f / 2;
}

}  // namespace

ContactSurface::ContactSurface(const SpringMesh& mesh) : outline_(mesh) {
    node_ = outline_.nodes();
    arc_ = outline_.arcs();
    for (int node : node_) rest_m_.emplace_back(mesh.nodes.row(node).transpose());
    const auto mirror = [](auto& list) {
        list.insert(list.begin(), 2 * list[0] - list[1]);
        list.push_back(2 * list[list.size() - 1] - list[list.size() - 2]);
    };
    mirror(arc_);
    rest_m_.insert(rest_m_.begin(), 2 * rest_m_[0] - rest_m_[1]);
    rest_m_.push_back(2 * rest_m_[rest_m_.size() - 1] - rest_m_[rest_m_.size() - 2]);
    node_.insert(node_.begin(), node_.front());
    node_.push_back(node_.back());
    std::map<std::pair<int, int>, std::size_t> on_line;
    const std::vector<int>& line = outline_.nodes();
    for (std::size_t s = 0; s + 1 < line.size(); ++s) on_line[{line[s], line[s + 1]}] = s;
    for (Eigen::Index b = 0; b < mesh.facets.rows(); ++b) {
        const int i = mesh.facets(b, 0), j = mesh.facets(b, 1);
        Segment segment{0, 0, {i, j}, (mesh.nodes.row(j) - mesh.nodes.row(i)).normalized().transpose()};
        const auto found = on_line.find({i, j});
        if (found != on_line.end()) {
            segment.first = outline_.arcs()[found->second];
            segment.last = outline_.arcs()[found->second + 1];
        } else {
            const auto off = [&](int end) { return (mesh.nodes.row(i) - mesh.nodes.row(end)).norm(); };
            segment.first = segment.last = off(line.front()) < off(line.back()) ? 0 : outline_.arcs().back();
        }
        segment_.push_back(segment);
    }
    for (std::size_t i = 1; i + 1 < arc_.size(); ++i) knot_.push_back((arc_[i - 1] + 4 * arc_[i] + arc_[i + 1]) / 6);
}

double ContactSurface::arc_at(int segment, double fraction) const noexcept {
    double w[4];
    spline_weights(fraction, w);
    const double* s = &arc_[static_cast<std::size_t>(segment)];
    return w[0] * s[0] + w[1] * s[1] + w[2] * s[2] + w[3] * s[3];
}

ContactPatch ContactSurface::at(double arc_m) const noexcept {
    const double s = std::clamp(arc_m, knot_.front(), knot_.back());
    const auto above = std::upper_bound(knot_.begin() + 1, knot_.end() - 1, s);
    const int segment = static_cast<int>(above - knot_.begin()) - 1;

    // sum w_i s_i increases with the fraction: Newton's method within brackets. One step suffices for evenly spaced
    // nodes.
    const double first = knot_[static_cast<std::size_t>(segment)], last = knot_[static_cast<std::size_t>(segment) + 1];
    double low = 0, high = 1, f = (s - first) / (last - first);
    const double* arcs = &arc_[static_cast<std::size_t>(segment)];
    for (int iteration = 0; iteration < 20; ++iteration) {
        const double off = arc_at(segment, f) - s;
        if (std::abs(off) <= 1e-15 * (last - first)) break;
        (off > 0 ? high : low) = f;
        double slope[4];
        spline_slopes(f, slope);
        const double next = f - off / (slope[0] * arcs[0] + slope[1] * arcs[1] + slope[2] * arcs[2] + slope[3] * arcs[3]);
        f = next >= low && next <= high ? next : (low + high) / 2;
    }

    ContactPatch patch;
    spline_weights(f, patch.weight);
    spline_slopes(f, patch.slope);
    patch.place = segment + f;
    Eigen::Vector2d along = Eigen::Vector2d::Zero();
    double spacing = 0;  // ds / d place
    for (int i = 0; i < ContactPatch::size; ++i) {
        const auto n = static_cast<std::size_t>(segment + i);
        patch.node[i] = node_[n];
        along += patch.slope[i] * rest_m_[n];
        spacing += patch.slope[i] * arc_[n];
    }
    // 1 - cos 45: at the node of a right angle the derivative's length is cos 45 of the spacing
    constexpr double right_angle = 0.29289321881345254;
    patch.corner = std::max(0.0, 1 - along.norm() / spacing) / right_angle;
    patch.log_scale = 0;
    for (int i = 0; i < ContactPatch::size; ++i) patch.log_scale += patch.weight[i] * log_scale_of(patch.node[i]);
    patch.edge = std::exp(-std::min(patch.place, static_cast<double>(knot_.size() - 1) - patch.place));
    patch.tangent = along.normalized();
    patch.normal << -patch.tangent.y(), patch.tangent.x();  // counter-clockwise: the tissue lies to the left
    return patch;
}

void ContactSurface::tool_at(int facet, const Eigen::Vector3d& weight, double /*radius_m*/, const ContactParameters& contact_parameters, ToolSpring& tool) const noexcept {
    const Segment& segment = segment_[static_cast<std::size_t>(facet)];
    ContactPatch patch = at(segment.first + weight[1] * (segment.last - segment.first));
    PatchStiffness k = contact_parameters.at(patch);
    if (segment.first == segment.last) {
        for (int i = 0; i < ContactPatch::size; ++i) {
            patch.node[i] = segment.node[i % 2];
            patch.weight[i] = i < 2 ? weight[i] : 0;
            patch.slope[i] = 0;
        }
        patch.tangent = segment.tangent;
        patch.normal << -patch.tangent.y(), patch.tangent.x();
        k.tangent = k.normal;
    }
    PatchSpring(patch, k).lay_out(tool);
}

void PatchSpring::lay_out(ToolSpring& tool) const noexcept {
    tool.begin(2, patch.normal);
    tool.add_group(Eigen::Matrix2d::Identity(), gap_N_m);
    for (int i = 0; i < ContactPatch::size; ++i) tool.add_node(patch.node[i], patch.weight[i]);
    tool.add_group(Eigen::Matrix2d::Zero(), turn_N_m);
    for (int i = 0; i < ContactPatch::size; ++i) tool.add_node(patch.node[i], patch.slope[i]);
}

Eigen::Vector4d ContactParameters::factors_at(const ContactPatch& patch) noexcept {
    constexpr double turn = 2 * 3.14159265358979323846;
    return {1, std::cos(turn * patch.place), patch.corner, patch.edge};
}

PatchStiffness ContactParameters::at(const ContactPatch& patch) const noexcept {
    const Eigen::Vector4d log_k = (log_N_m.topRows<4>() * factors_at(patch)).array() + patch.log_scale;
    return {std::exp(log_k[0]), std::exp(log_k[1]), std::exp(log_k[2]), std::exp(log_k[3])};
}

Eigen::VectorXd ContactParameters::values_at(const ContactFactors& at, double log_scale) const {
    Eigen::VectorXd value = (log_N_m * at).array().exp();
    for (Eigen::Index m = 0; m < value.size(); ++m) value[m] *= scaled(m, std::exp(log_scale));
    return value;
}

PatchSpring::PatchSpring(const ContactPatch& where, const PatchStiffness& k) noexcept : patch(where), stiffness(k) {
    const Eigen::Matrix2d nn = patch.normal * patch.normal.transpose(), tt = patch.tangent * patch.tangent.transpose();
    gap_N_m = k.normal * nn + k.tangent * tt;
    turn_N_m = k.rotation * nn + k.stretch * tt;
}

PatchSpring::Load PatchSpring::load(const Eigen::Vector2d& push_m,
                                    const Eigen::Vector2d (&u)[ContactPatch::size]) const noexcept {
    Eigen::Vector2d gap = push_m, turn = Eigen::Vector2d::Zero();
    for (int i = 0; i < ContactPatch::size; ++i) {
        gap -= patch.weight[i] * u[i];
        turn += patch.slope[i] * u[i];
    }
    Load load;
    load.tool_force_N = gap_N_m * gap;
    const Eigen::Vector2d held = turn_N_m * turn;
    load.energy_J = (load.tool_force_N.dot(gap) + held.dot(turn)) / 2;
    for (int i = 0; i < ContactPatch::size; ++i) load.node_N[i] = patch.slope[i] * held - patch.weight[i] * load.tool_force_N;
    return load;
}

}  // namespace tissue
