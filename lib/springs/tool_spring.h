#pragma once

#include <Eigen/Core>

#include <limits>

#include "field.h"
#include "springs/bound_rings.h"

namespace tissue {

class ToolSpring;

/// State of the Maxwell branches of a contact (springs/relaxation.h) for steps of constant length: for each group the
/// force T0 = dE/de at its gap e in the last step, and Q_k of each branch,
///   T = (1 - sum g_k) T0 + sum Q_k,   Q_k <- e_k Q_k + g_k c_k (T0 - T0_before)
/// in the gap's own axes; e_k and c_k as in springs/branch_memory.h. It is exact where T0 changes linearly, and passive
/// for every convex E and every dt / tau_k: the stored energy
///   (1 - sum g_k) E(e) + sum g_k (E(e) - E(v_k) - T0(v_k) (e - v_k)) with T0(v_k) = T0(e) - Q_k / g_k
/// increases by at most the work of T at the step's end. The reason is that T0(v_k) is then a mean of T0(e),
/// T0(e_before) and the previous T0(v_k), with the weights 1 - c_k, c_k - e_k and e_k. Fixed storage: nothing
/// allocates.
class ToolMemory {
   public:
    static constexpr int most_branches = 8, most_groups = 61;

    ToolMemory() { forget(); }  ///< of a contact that does not relax
    /// tau_s, share (K): relaxation times [s] and relative moduli. dt_s: length of a step [s]. Throws MismatchError for
    /// more than most_branches.
    ToolMemory(const Eigen::VectorXd& tau_s, const Eigen::VectorXd& share, double dt_s);

    bool empty() const { return branches_ == 0; }

    /// Resets the state for a new contact without history.
    void forget() noexcept;
    /// The contact has moved along the surface and is now `to`. Groups keep their state by number. Groups that `from`
    /// did not have, as on a fixed facet, start without history.
    void follow(const ToolSpring& from, const ToolSpring& to) noexcept;
    /// T0 of this group has changed by a factor at the same place. The state becomes that of the new stiffness over the
    /// whole history.
    void scale(int group, double factor) noexcept;

    /// T of a group in the coming step if its instantaneous force is T0 = now_N.
    Eigen::Vector3d felt_N(int group, const Eigen::Vector3d& now_N) const noexcept { return branches_ == 0 ? now_N : Eigen::Vector3d(left_ * now_N + known_[group]); }
    double left() const { return left_; }  ///< dT / dT0 within a step
    const Eigen::Vector3d& known_N(int group) const { return known_[group]; }

    /// Ends a step at T0 = now_N.
    void step(int group, const Eigen::Vector3d& now_N) noexcept;

    template <class State>
    void fields(State& state) noexcept {
        if (empty()) return;
        state(before_, known_);
        for (int k = 0; k < branches_; ++k) state(part_[k]);
    }

   private:
    void know(int group) noexcept;

    int branches_ = 0;
    double left_ = 1;
    double decay_[most_branches] = {}, risen_[most_branches] = {};  ///< e, g c
    /// T0 in the last step; T in the coming step at T0 = 0
    Eigen::Vector3d before_[most_groups], known_[most_groups];
    Eigen::Vector3d part_[most_branches][most_groups];              ///< Q
};

/// Energy of one contact (springs/contact_spring.h) in the form of the tick: the same rows, with the three rows of one
/// place combined into a group, in fixed storage. With gap_g = target_g d - sum_i weight_gi u_i and the stiffness K_g
/// of the rows,
///   E = sum_g gap_g' K_g gap_g / 2 + hardening s^2 / (2 (1 + saturation s)) + coupling e_n |e_t|^2 / 2,
/// where s is the first group's part of the sum, and e_n, e_t are its gap along and across the inward normal.
///
/// Limited force: where |dE/dd| would exceed the limit F, the tool stays at q behind the prescribed displacement p:
///   E(p, u) = min over q of E(q, u) + F |p - q|.
/// This is convex where E is, and its force on the tissue is F. F must stay constant: if it grew, the energy F |p - q|
/// would grow without work. Nothing here allocates or throws.
///
/// Growing contact (a ball's): its force on the tool has the additional part dE/da a'(d). Within a tick that part is
/// constant and along the inward normal n. The contact is bound where it grows (springs/bound_rings.h): along the
/// surface its spring is stretched from anchor_m, the mean of the places where its rings were bound:
///   E(p - anchor_m, u) + force_N (n p - depth_m)
class ToolSpring {
   public:
    /// State of a growing contact within a tick.
    struct Growth {
        double radius_m = 0;             ///< of the contact; 0: it does not grow
        /// dE/da a'(d), and the depth n d at which it was computed
        double force_N = 0, depth_m = 0;
        Eigen::Vector3d anchor_m = Eigen::Vector3d::Zero();
        BoundRings rings;

        template <class State>
        void fields(State& state) noexcept { state(radius_m, force_N, depth_m, anchor_m, rings); }
    };

    static constexpr int most_nodes = 60;      ///< of the imprint, each a group
    static constexpr int most_entries = 960;   ///< nodes of all groups together

    /// Clears all groups, for a contact with that many axes and that inward normal at rest. The force limit stays.
    void begin(int dimension, const Point& inward) noexcept;

    /// Adds the next group. target, stiffness_N_m: (D x D). False when there is no room.
    bool add_group(const PointMatrix& target, const PointMatrix& stiffness_N_m) noexcept;
    /// to the last group; a node may occur twice; false when there is no room
    bool add_node(int node, double weight) noexcept;
    /// in_compression: s is the energy of the normal part of the first group's gap, and 0 where that part is not inward.
    /// coupling_bound_1_m: of ContactCoupling.
    void harden(double hardening_1_J, double saturation_1_J, double coupling_N_m2, bool in_compression = false, double coupling_bound_1_m = 0) noexcept;
    void grow(const Growth& growth) noexcept { growth_ = growth; }
    const Growth& growth() const { return growth_; }
    /// Sets the force limit F [N], also for later contacts of this object; initially infinite.
    void show_at_most(double force_N) noexcept { most_N_ = force_N; }
    double most_N() const { return most_N_; }

    int dimension() const { return dimension_; }
    Point inward() const { return inward_.head(dimension_); }

    // memory: state of a contact that relaxes; null or empty: the instantaneous contact. With it, E within the coming
    // step is replaced by (1 - sum g (1 - c)) E plus a history term that is linear in the gaps. It is convex where E
    // is.

    /// dE/dd: force of the tool on the tissue [N] (D) at a tool displacement push_m [m] (D) and displacements u [m] (N
    /// x D).
    Point tool_force_N(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;
    /// The first group's part of it, without the imprint.
    Point mean_N(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;
    /// Same result as tool_force_N. Adds dE/du, the nodal forces that hold u against the contact, to f (N x D). Advances
    /// memory by a step.
    Point put_on(const Point& push_m, const NodeColumns& u, NodeColumns& f, ToolMemory* memory = nullptr) const noexcept;
    /// Advances memory by a step while the tool exerts no force on the tissue.
    void remember(const Point& push_m, const NodeColumns& u, ToolMemory& memory) const noexcept;
    /// Adapts memory when this contact replaces `from`, the same contact of another energy model, at the current push_m
    /// and u.
    void take_over(const ToolSpring& from, const Point& push_m, const NodeColumns& u, ToolMemory& memory) const noexcept;
    double energy_J(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;
    /// q (D): push_m, or the displacement at which the force is limited.
    Point shown_push(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept { return (shown(stretch(push_m), u, memory) + growth_.anchor_m).head(dimension_); }
    /// Second derivative of E by d at fixed nodes [N/m] (D x D).
    PointMatrix stiffness_N_m(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;

    /// Tool displacement [m] at which the force is tool_force_N, which must not exceed the limit. Newton's method from the
    /// first group's weighted displacement, up to 8 steps.
    Point push_at(const Point& tool_force_N, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;

    int group_count() const { return groups_; }

   private:
    struct Group {
        Eigen::Matrix3d target, stiffness;
        int begin, end;  ///< range of its nodes
    };
    struct Hardening {
        double s, rise, bend;
        Eigen::Matrix3d stiffness;    ///< K_h: the part of the first group's K that hardens
        /// K_h gap of the first group, and the nonlinear part that is added to K gap
        Eigen::Vector3d pull, slope;
    };
    Eigen::Vector3d whole_N(const Eigen::Vector3d& push, const NodeColumns& u, const ToolMemory* memory) const noexcept;
    Eigen::Vector3d shown(const Eigen::Vector3d& push, const NodeColumns& u, const ToolMemory* memory) const noexcept;
    Eigen::Vector3d stay_behind(const Eigen::Vector3d& push, const Eigen::Vector3d& whole, const NodeColumns& u, const ToolMemory* memory) const noexcept;
    Eigen::Vector3d gap(const Group& group, const Eigen::Vector3d& push, const NodeColumns& u) const noexcept;
    Eigen::Vector3d now_N(int group, const Eigen::Vector3d& gap) const noexcept;
    Eigen::Vector3d felt_N(int group, const Eigen::Vector3d& gap, const ToolMemory* memory) const noexcept;
    Eigen::Vector3d tissue(const Group& group, const NodeColumns& u) const noexcept;
    Hardening hardened(const Eigen::Vector3d& gap) const noexcept;
    Eigen::Matrix3d first_stiffness(const Eigen::Vector3d& gap) const noexcept;
    Eigen::Matrix3d curvature(const Eigen::Vector3d& push, const NodeColumns& u) const noexcept;
    Eigen::Vector3d in_space(const Point& p) const noexcept;
    Eigen::Vector3d stretch(const Point& push) const noexcept;

    int dimension_ = 2, groups_ = 0, nodes_ = 0;
    Eigen::Vector3d inward_ = Eigen::Vector3d::Zero();
    Growth growth_;
    bool in_compression_ = false;
    double coupling_bound_1_m_ = 0;
    double hardening_1_J_ = 0, saturation_1_J_ = 0, coupling_N_m2_ = 0, most_N_ = std::numeric_limits<double>::infinity();
    /// second derivative by d of the energy of all groups but the first
    Eigen::Matrix3d imprint_N_m_ = Eigen::Matrix3d::Zero();
    Group group_[most_nodes + 1];
    int node_[most_entries];
    double weight_[most_entries];
};

}  // namespace tissue
