#pragma once

#include <Eigen/Core>

#include <limits>

#include "field.h"
#include "springs/bound_rings.h"

namespace tissue {

class ToolSpring;

/// What a contact remembers while it moves in steps of one length, where it relaxes (springs/relaxation.h): of each of its groups the
/// force T0 = dE/de that its gap e had a step ago, and of each branch Q_k,
///   T = (1 - sum g_k) T0 + sum Q_k,   Q_k <- e_k Q_k + g_k c_k (T0 - T0_before)
/// in the gap's own axes, exact where T0 goes straight. Passive for every convex E and every dt / tau: what is stored,
///   (1 - sum g_k) E(e) + sum g_k (E(e) - E(v_k) - T0(v_k) (e - v_k)) with T0(v_k) = T0(e) - Q_k / g_k,
/// grows by the work of T at a step's end at most, since T0(v_k) is then a mean of T0(e), T0(e_before) and T0(v_k) before, weights 1 - c_k,
/// c_k - e_k and e_k. Storage of its own: nothing allocates.
class ToolMemory {
   public:
    static constexpr int most_branches = 8, most_groups = 61;

    ToolMemory() { forget(); }  ///< of a contact that does not relax
    /// Throws MismatchError for more than most_branches.
    ToolMemory(const Eigen::VectorXd& tau_s, const Eigen::VectorXd& share, double dt_s);

    bool empty() const { return branches_ == 0; }

    /// A contact that begins: it has felt nothing.
    void forget() noexcept;
    /// The contact has gone along the surface, and is another. Its groups go with the tool, and what they remember with them; those that it did not have, as on a held facet, have felt nothing.
    void follow(const ToolSpring& from, const ToolSpring& to) noexcept;
    /// The contact has become stiffer or softer where it is, by a factor on this group's T0: it remembers what it would have felt so from the beginning.
    void scale(int group, double factor) noexcept;

    /// T of a group at T0, within the step that comes.
    Eigen::Vector3d felt_N(int group, const Eigen::Vector3d& now_N) const noexcept { return branches_ == 0 ? now_N : Eigen::Vector3d(left_ * now_N + known_[group]); }
    double left() const { return left_; }  ///< dT / dT0 within a step
    const Eigen::Vector3d& known_N(int group) const { return known_[group]; }

    /// The step ends at T0.
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
    Eigen::Vector3d before_[most_groups], known_[most_groups];      ///< T0 a step ago, and T of the step that comes at T0 = 0
    Eigen::Vector3d part_[most_branches][most_groups];              ///< Q
};

/// One contact's energy (springs/contact_spring.h) as the tick holds it: the same rows, those along the axes of one place taken
/// together, in storage of its own. With gap_g = target_g d - sum_i weight_gi u_i and K_g the rows' stiffness,
///   E = sum_g gap_g' K_g gap_g / 2 + hardening s^2 / (2 (1 + saturation s)) + coupling e_n |e_t|^2 / 2
/// where s is the first group's part of the sum, and e_n, e_t are its gap along and across the inward normal.
/// Where dE/dd would be larger than the largest force F that the tool may show, the tool stays behind the push p, at q:
///   E(p, u) = min over q of E(q, u) + F |p - q|
/// which is convex where E is, and whose force on the tissue is then F. F stays as it is: one that grows would lift what |p - q| holds, and give energy. Nothing here allocates or throws.
///
/// A contact that grows as the tool goes in, a ball's, has more force on the tool than its spring: dE/da a'(d). Within a tick that is taken as constant, along the inward normal n. And it is bound where it
/// grows (springs/bound_rings.h): along the surface its spring is stretched from anchor_m, the mean of where its rings were bound:
///   E(p - anchor_m, u) + force_N (n p - depth_m)
class ToolSpring {
   public:
    /// Of a contact that grows: what it is in this tick.
    struct Growth {
        double radius_m = 0;             ///< of the contact; 0: it does not grow
        double force_N = 0, depth_m = 0; ///< dE/da a'(d), and the depth n d where it is that
        Eigen::Vector3d anchor_m = Eigen::Vector3d::Zero();
        BoundRings rings;

        template <class State>
        void fields(State& state) noexcept { state(radius_m, force_N, depth_m, anchor_m, rings); }
    };

    static constexpr int most_nodes = 60;      ///< of the imprint: a group each
    static constexpr int most_entries = 960;   ///< of all groups' nodes

    /// Empties it: a contact of so many axes at a surface with this inward normal at rest.
    void begin(int dimension, const Point& inward) noexcept;

    /// The next group. target, stiffness: (D x D). False when there is no room.
    bool add_group(const PointMatrix& target, const PointMatrix& stiffness_N_m) noexcept;
    bool add_node(int node, double weight) noexcept;  ///< of the last group; one may come twice
    void harden(double hardening_1_J, double saturation_1_J, double coupling_N_m2) noexcept;
    void grow(const Growth& growth) noexcept { growth_ = growth; }
    const Growth& growth() const { return growth_; }
    /// The largest force that the tool may show from now on, in other contacts too [N]; infinite from the start.
    void show_at_most(double force_N) noexcept { most_N_ = force_N; }
    double most_N() const { return most_N_; }

    int dimension() const { return dimension_; }
    Point inward() const { return inward_.head(dimension_); }

    // memory: of a contact that relaxes; without one, or with an empty one, the instantaneous contact. What is asked of E is then, within
    // the step that comes, of (1 - sum g (1 - c)) E plus what the past adds, linear in the gaps: as convex as E.

    /// dE/dd: the force of the tool on the tissue [N] (D), at a push d (D) and displacements u (N x D) [m].
    Point hand_N(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;
    /// The first group's part of it, without the imprint.
    Point mean_N(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;
    /// The same as hand_N. Adds dE/du, what the contact asks of the rest to hold u, to f (N x D). memory goes on by a step.
    Point put_on(const Point& push_m, const NodeColumns& u, NodeColumns& f, ToolMemory* memory = nullptr) const noexcept;
    /// A step of memory alone, while the tool puts nothing on the tissue.
    void remember(const Point& push_m, const NodeColumns& u, ToolMemory& memory) const noexcept;
    /// The same contact of another law takes memory over from `from`, at a push and displacements of now.
    void take_over(const ToolSpring& from, const Point& push_m, const NodeColumns& u, ToolMemory& memory) const noexcept;
    double energy_J(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;
    /// q (D): the push, or less where that would take more than the largest force.
    Point shown_push(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept { return (shown(stretch(push_m), u, memory) + growth_.anchor_m).head(dimension_); }
    /// Second derivative of E by d, nodes held [N/m] (D x D).
    PointMatrix stiffness_N_m(const Point& push_m, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;

    /// The push at which the tool's force is this one, which is not above the largest: Newton from where the first group alone would have it.
    Point push_at(const Point& hand_N, const NodeColumns& u, const ToolMemory* memory = nullptr) const noexcept;

    int group_count() const { return groups_; }

   private:
    struct Group {
        Eigen::Matrix3d target, stiffness;
        int begin, end;  ///< of its nodes
    };
    struct Hardening {
        double s, rise, bend;
        Eigen::Vector3d pull, slope;  ///< K gap of the first group, and what is added to it
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
    double hardening_1_J_ = 0, saturation_1_J_ = 0, coupling_N_m2_ = 0, most_N_ = std::numeric_limits<double>::infinity();
    Eigen::Matrix3d imprint_N_m_ = Eigen::Matrix3d::Zero();  ///< second derivative of E by d of all groups but the first
    Group group_[most_nodes + 1];
    int node_[most_entries];
    double weight_[most_entries];
};

}  // namespace tissue
