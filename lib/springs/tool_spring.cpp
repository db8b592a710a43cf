#include "springs/tool_spring.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "error.h"
#include "springs/contact_coupling.h"

namespace tissue {

ToolMemory::ToolMemory(const Eigen::VectorXd& tau_s, const Eigen::VectorXd& share, double dt_s) : branches_(static_cast<int>(tau_s.size())) {
    static_assert(most_groups == ToolSpring::most_nodes + 1);
    if (branches_ > most_branches) throw MismatchError(fmt::format("a contact has {} Maxwell branches; a tick supports at most {}", branches_, most_branches));
    for (int k = 0; k < branches_; ++k) {
        decay_[k] = std::exp(-dt_s / tau_s[k]);
        const double mean = -std::expm1(-dt_s / tau_s[k]) * tau_s[k] / dt_s;
        risen_[k] = share[k] * mean;
        left_ -= share[k] * (1 - mean);
    }
    forget();
}

void ToolMemory::forget() noexcept {
    for (int g = 0; g < most_groups; ++g) {
        before_[g].setZero();
        known_[g].setZero();
        for (int k = 0; k < branches_; ++k) part_[k][g].setZero();
    }
}

void ToolMemory::know(int group) noexcept {
    known_[group].setZero();
    for (int k = 0; k < branches_; ++k) known_[group] += decay_[k] * part_[k][group] - risen_[k] * before_[group];
}

void ToolMemory::step(int group, const Eigen::Vector3d& now_N) noexcept {
    const Eigen::Vector3d by = now_N - before_[group];
    for (int k = 0; k < branches_; ++k) part_[k][group] = decay_[k] * part_[k][group] + risen_[k] * by;
    before_[group] = now_N;
    know(group);
}

void ToolMemory::follow(const ToolSpring& from, const ToolSpring& to) noexcept {
    for (int g = from.group_count(); g < to.group_count(); ++g) {
        before_[g].setZero();
        for (int k = 0; k < branches_; ++k) part_[k][g].setZero();
        know(g);
    }
}

void ToolMemory::scale(int group, double factor) noexcept {
    before_[group] *= factor;
    for (int k = 0; k < branches_; ++k) part_[k][group] *= factor;
    know(group);
}

void ToolSpring::begin(int dimension, const Point& inward) noexcept {
    dimension_ = dimension;
    groups_ = nodes_ = 0;
    inward_ = in_space(inward);
    hardening_1_J_ = saturation_1_J_ = coupling_N_m2_ = 0;
    in_compression_ = false;
    coupling_bound_1_m_ = 0;
    growth_ = {};
    imprint_N_m_.setZero();
}

bool ToolSpring::add_group(const PointMatrix& target, const PointMatrix& stiffness_N_m) noexcept {
    if (groups_ > most_nodes) return false;
    Group& group = group_[groups_++];
    group.target.setZero();
    group.stiffness.setZero();
    group.target.topLeftCorner(dimension_, dimension_) = target;
    group.stiffness.topLeftCorner(dimension_, dimension_) = stiffness_N_m;
    group.begin = group.end = nodes_;
    if (groups_ > 1) imprint_N_m_ += group.target.transpose() * group.stiffness * group.target;
    return true;
}

bool ToolSpring::add_node(int node, double weight) noexcept {
    if (nodes_ >= most_entries) return false;
    node_[nodes_] = node;
    weight_[nodes_] = weight;
    group_[groups_ - 1].end = ++nodes_;
    return true;
}

void ToolSpring::harden(double hardening_1_J, double saturation_1_J, double coupling_N_m2, bool in_compression, double coupling_bound_1_m) noexcept {
    in_compression_ = in_compression;
    coupling_bound_1_m_ = coupling_bound_1_m;
    hardening_1_J_ = hardening_1_J;
    saturation_1_J_ = saturation_1_J;
    coupling_N_m2_ = coupling_N_m2;
}

Eigen::Vector3d ToolSpring::in_space(const Point& p) const noexcept {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    v.head(dimension_) = p;
    return v;
}

/// Stretch of the contact's spring by a tool displacement.
Eigen::Vector3d ToolSpring::stretch(const Point& push) const noexcept { return in_space(push) - growth_.anchor_m; }

Eigen::Vector3d ToolSpring::tissue(const Group& group, const NodeColumns& u) const noexcept {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = group.begin; k < group.end; ++k)
        for (int axis = 0; axis < dimension_; ++axis) sum[axis] += weight_[k] * u(node_[k], axis);
    return sum;
}

Eigen::Vector3d ToolSpring::gap(const Group& group, const Eigen::Vector3d& push, const NodeColumns& u) const noexcept {
    return group.target * push - tissue(group, u);
}

/// Hardening and coupling terms at the first group's gap, as in ContactSpring::State.
ToolSpring::Hardening ToolSpring::hardened(const Eigen::Vector3d& gap) const noexcept {
    Hardening h{};
    const Eigen::Matrix3d& k = group_[0].stiffness;
    const double in = inward_.dot(gap);
    h.stiffness = !in_compression_ ? k : in > 0 ? Eigen::Matrix3d(inward_.dot(k * inward_) * inward_ * inward_.transpose()) : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
    h.pull = h.stiffness * gap;
    h.s = h.pull.dot(gap) / 2;
    const double room = 1 + saturation_1_J_ * h.s;
    h.rise = hardening_1_J_ * (h.s + saturation_1_J_ * h.s * h.s / 2) / (room * room);
    h.bend = hardening_1_J_ / (room * room * room);
    const Eigen::Vector3d across = gap - in * inward_;
    const ContactCoupling c(in, coupling_bound_1_m_);
    h.slope = h.rise * h.pull + coupling_N_m2_ * (c.slope * across.squaredNorm() / 2 * inward_ + c.s * across);
    return h;
}

/// T0 = dE/de of a group.
Eigen::Vector3d ToolSpring::now_N(int group, const Eigen::Vector3d& e) const noexcept {
    Eigen::Vector3d q = group_[group].stiffness * e;
    if (group == 0) q += hardened(e).slope;
    return q;
}

Eigen::Vector3d ToolSpring::felt_N(int group, const Eigen::Vector3d& e, const ToolMemory* memory) const noexcept {
    return memory ? memory->felt_N(group, now_N(group, e)) : now_N(group, e);
}

/// dE/dd, not limited.
Eigen::Vector3d ToolSpring::whole_N(const Eigen::Vector3d& push, const NodeColumns& u, const ToolMemory* memory) const noexcept {
    Eigen::Vector3d hand = Eigen::Vector3d::Zero();
    if (growth_.radius_m > 0) hand += growth_.force_N * inward_;
    for (int g = 0; g < groups_; ++g) hand += group_[g].target.transpose() * felt_N(g, gap(group_[g], push, u), memory);
    return hand;
}

/// q: displacement of the tool when its force is limited.
Eigen::Vector3d ToolSpring::shown(const Eigen::Vector3d& push, const NodeColumns& u, const ToolMemory* memory) const noexcept {
    return std::isinf(most_N_) ? push : stay_behind(push, whole_N(push, u, memory), u, memory);
}

/// The same for a known force at `push`: solves dE/dd(q) = F (p - q) / |p - q| by Newton's method with halved steps.
/// Only the first group is nonlinear in q, so each step evaluates that group alone.
Eigen::Vector3d ToolSpring::stay_behind(const Eigen::Vector3d& push, const Eigen::Vector3d& whole, const NodeColumns& u, const ToolMemory* memory) const noexcept {
    constexpr int most_steps = 30, most_halvings = 10;
    constexpr double near = 1e-9;  // over F
    const double size = whole.norm();
    if (!(size > most_N_ * (1 + near))) return push;
    const Group& first = group_[0];
    const double left = memory ? memory->left() : 1.0;
    const Eigen::Vector3d gap_at_push = gap(first, push, u), rest = whole - first.target.transpose() * felt_N(0, gap_at_push, memory);
    const auto force = [&](const Eigen::Vector3d& q) {
        return Eigen::Vector3d(rest + left * imprint_N_m_ * (q - push) + first.target.transpose() * felt_N(0, gap_at_push + first.target * (q - push), memory));
    };
    const auto stiffness = [&](const Eigen::Vector3d& q) {
        Eigen::Matrix3d k = left * (imprint_N_m_ + first_stiffness(gap_at_push + first.target * (q - push)));
        if (dimension_ == 2) k(2, 2) = 1;
        return k;
    };
    const auto off = [&](const Eigen::Vector3d& q) { return Eigen::Vector3d(force(q) - most_N_ * (push - q).normalized()); };
    const Eigen::Vector3d along = whole / size;
    Eigen::Vector3d q = push - (size - most_N_) / along.dot(stiffness(push) * along) * along;
    // Where Newton's method fails, which a convex energy does not cause: a point on the line from the tissue to the tool
    // before the force exceeds F. It limits the force; it is no minimum of E(q) + F |p - q|.
    const auto on_the_line = [&] {
        const Eigen::Vector3d from = tissue(first, u);
        double low = 0, high = 1;
        for (int half = 0; half < most_steps; ++half) {
            const double middle = (low + high) / 2;
            (force(from + middle * (push - from)).norm() > most_N_ ? high : low) = middle;
        }
        return Eigen::Vector3d(from + low * (push - from));
    };
    if (!((push - q).dot(along) > 0)) return on_the_line();
    Eigen::Vector3d wrong = off(q);
    for (int step = 0; step < most_steps && wrong.norm() > near * most_N_; ++step) {
        const Eigen::Vector3d behind = push - q;
        const double length = behind.norm();
        if (!(length > 0)) break;
        const Eigen::Vector3d way = behind / length;
        Eigen::Vector3d change = -(stiffness(q) + most_N_ / length * (Eigen::Matrix3d::Identity() - way * way.transpose())).inverse() * wrong;
        bool nearer = false;
        for (int half = 0; half < most_halvings && !nearer; ++half, change /= 2) {
            const Eigen::Vector3d next = q + change, next_wrong = off(next);
            nearer = next_wrong.norm() < wrong.norm();
            if (!nearer) continue;
            q = next;
            wrong = next_wrong;
        }
        if (!nearer) break;
    }
    return wrong.norm() > 1e-3 * most_N_ ? on_the_line() : q;
}

Point ToolSpring::tool_force_N(const Point& push_m, const NodeColumns& u, const ToolMemory* memory) const noexcept {
    const Eigen::Vector3d push = stretch(push_m), whole = whole_N(push, u, memory);
    if (!(whole.norm() > most_N_)) return whole.head(dimension_);
    return whole_N(stay_behind(push, whole, u, memory), u, memory).head(dimension_);
}

Point ToolSpring::mean_N(const Point& push_m, const NodeColumns& u, const ToolMemory* memory) const noexcept {
    if (groups_ == 0) return Point::Zero(dimension_);
    const Eigen::Vector3d q = felt_N(0, gap(group_[0], shown(stretch(push_m), u, memory), u), memory);
    return (group_[0].target.transpose() * q).head(dimension_);
}

Point ToolSpring::put_on(const Point& push_m, const NodeColumns& u, NodeColumns& f, ToolMemory* memory) const noexcept {
    Eigen::Vector3d now[most_nodes + 1];
    const auto at = [&](const Eigen::Vector3d& push) {
        Eigen::Vector3d hand = Eigen::Vector3d::Zero();
        if (growth_.radius_m > 0) hand += growth_.force_N * inward_;
        for (int g = 0; g < groups_; ++g) {
            now[g] = now_N(g, gap(group_[g], push, u));
            hand += group_[g].target.transpose() * (memory ? memory->felt_N(g, now[g]) : now[g]);
        }
        return hand;
    };
    const Eigen::Vector3d push = stretch(push_m);
    Eigen::Vector3d hand = at(push);
    if (hand.norm() > most_N_) hand = at(stay_behind(push, hand, u, memory));
    for (int g = 0; g < groups_; ++g) {
        const Group& group = group_[g];
        const Eigen::Vector3d q = memory ? memory->felt_N(g, now[g]) : now[g];
        if (memory) memory->step(g, now[g]);
        for (int k = group.begin; k < group.end; ++k)
            for (int axis = 0; axis < dimension_; ++axis) f(node_[k], axis) -= weight_[k] * q[axis];
    }
    return hand.head(dimension_);
}

void ToolSpring::remember(const Point& push_m, const NodeColumns& u, ToolMemory& memory) const noexcept {
    const Eigen::Vector3d push = stretch(push_m);
    for (int g = 0; g < groups_; ++g) memory.step(g, now_N(g, gap(group_[g], push, u)));
}

void ToolSpring::take_over(const ToolSpring& from, const Point& push_m, const NodeColumns& u, ToolMemory& memory) const noexcept {
    const Eigen::Vector3d push = from.shown(stretch(push_m), u, &memory);
    for (int g = 0; g < std::min(groups_, from.groups_); ++g) {
        const Eigen::Vector3d e = gap(group_[g], push, u);
        const double before_N = from.now_N(g, e).norm(), after_N = now_N(g, e).norm();
        if (before_N > 0) memory.scale(g, after_N / before_N);
    }
}

double ToolSpring::energy_J(const Point& push_m, const NodeColumns& u, const ToolMemory* memory) const noexcept {
    const Eigen::Vector3d push = shown(stretch(push_m), u, memory);
    double energy = growth_.force_N * (inward_.dot(push) - growth_.depth_m), past = 0;
    for (int g = 0; g < groups_; ++g) {
        const Eigen::Vector3d e = gap(group_[g], push, u);
        energy += e.dot(group_[g].stiffness * e) / 2;
        if (memory) past += memory->known_N(g).dot(e);
        if (g > 0) continue;
        const Hardening h = hardened(e);
        const double in = inward_.dot(e);
        energy += hardening_1_J_ * h.s * h.s / (2 * (1 + saturation_1_J_ * h.s)) + coupling_N_m2_ * ContactCoupling(in, coupling_bound_1_m_).s * (e - in * inward_).squaredNorm() / 2;
    }
    const double behind_m = (stretch(push_m) - push).norm();
    return (memory ? memory->left() * energy + past : energy) + (behind_m > 0 ? most_N_ * behind_m : 0);
}

/// Second derivative by d of the first group's energy at the gap e.
Eigen::Matrix3d ToolSpring::first_stiffness(const Eigen::Vector3d& e) const noexcept {
    const Hardening h = hardened(e);
    const double in = inward_.dot(e);
    const Eigen::Vector3d across = e - in * inward_;
    Eigen::Matrix3d k = group_[0].stiffness;
    k += h.rise * h.stiffness + h.bend * h.pull * h.pull.transpose();
    const ContactCoupling c(in, coupling_bound_1_m_);
    const Eigen::Matrix3d nn = inward_ * inward_.transpose();
    k += coupling_N_m2_ * (c.curvature * across.squaredNorm() / 2 * nn + c.slope * (inward_ * across.transpose() + across * inward_.transpose()) + c.s * (Eigen::Matrix3d::Identity() - nn));
    return group_[0].target.transpose() * k * group_[0].target;
}

Eigen::Matrix3d ToolSpring::curvature(const Eigen::Vector3d& push, const NodeColumns& u) const noexcept {
    return groups_ == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Zero()) : Eigen::Matrix3d(imprint_N_m_ + first_stiffness(gap(group_[0], push, u)));
}

PointMatrix ToolSpring::stiffness_N_m(const Point& push_m, const NodeColumns& u, const ToolMemory* memory) const noexcept {
    const Eigen::Vector3d push = stretch(push_m), q = shown(push, u, memory), behind = push - q;
    Eigen::Matrix3d stiffness = (memory ? memory->left() : 1.0) * curvature(q, u);
    const double length = behind.norm();
    // in series with F |p - q|, whose second derivative is `turning`
    if (length > 0) {
        if (dimension_ == 2) stiffness(2, 2) = 1;
        const Eigen::Matrix3d turning = most_N_ / length * (Eigen::Matrix3d::Identity() - behind * behind.transpose() / (length * length));
        stiffness = turning - turning * (stiffness + turning).inverse() * turning;
    }
    return stiffness.topLeftCorner(dimension_, dimension_);
}

Point ToolSpring::push_at(const Point& hand_N_asked, const NodeColumns& u, const ToolMemory* memory) const noexcept {
    constexpr int most_steps = 8;
    const Eigen::Vector3d asked = in_space(hand_N_asked);
    Eigen::Vector3d push = tissue(group_[0], u);
    for (int step = 0; step < most_steps; ++step) {
        const Eigen::Vector3d off = asked - whole_N(push, u, memory);
        if (!(off.norm() > 1e-12 * asked.norm())) break;
        Eigen::Matrix3d k = (memory ? memory->left() : 1.0) * curvature(push, u);
        if (dimension_ == 2) k(2, 2) = 1;
        push += k.inverse() * off;
    }
    push += growth_.anchor_m;
    return push.head(dimension_);
}

}  // namespace tissue
