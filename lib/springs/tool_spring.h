#pragma once

#include <Eigen/Core>

#include "field.h"

namespace tissue {

/// One contact's energy (springs/contact_spring.h) as the tick holds it: the same rows, those along the axes of one place taken
/// together, in storage of its own. With gap_g = target_g d - sum_i weight_gi u_i and K_g the rows' stiffness,
///   E = sum_g gap_g' K_g gap_g / 2 + hardening s^2 / (2 (1 + saturation s)) + coupling e_n |e_t|^2 / 2
/// where s is the first group's part of the sum, and e_n, e_t are its gap along and across the inward normal. Nothing here
/// allocates or throws.
class ToolSpring {
   public:
    static constexpr int most_nodes = 128;

    /// Empties it: a contact of so many axes at a surface with this inward normal at rest.
    void begin(int dimension, const Point& inward) noexcept;

    /// The next group. target, stiffness: (D x D). False when there is no room.
    bool add_group(const PointMatrix& target, const PointMatrix& stiffness_N_m) noexcept;
    bool add_node(int node, double weight) noexcept;  ///< of the last group; one may come twice
    void harden(double hardening_1_J, double saturation_1_J, double coupling_N_m2) noexcept;

    int dimension() const { return dimension_; }
    Point inward() const { return inward_.head(dimension_); }

    /// dE/dd: the force of the tool on the tissue [N] (D), at a push d (D) and displacements u (N x D) [m].
    Point hand_N(const Point& push_m, const NodeColumns& u) const noexcept;
    /// The first group's part of it, without the imprint.
    Point mean_N(const Point& push_m, const NodeColumns& u) const noexcept;
    /// The same as hand_N. Adds dE/du, what the contact asks of the rest to hold u, to f (N x D).
    Point put_on(const Point& push_m, const NodeColumns& u, NodeColumns& f) const noexcept;
    double energy_J(const Point& push_m, const NodeColumns& u) const noexcept;
    /// Second derivative of E by d, nodes held [N/m] (D x D).
    PointMatrix stiffness_N_m(const Point& push_m, const NodeColumns& u) const noexcept;

    /// The push at which the tool's force is this one: Newton from where the first group alone would have it.
    Point push_at(const Point& hand_N, const NodeColumns& u) const noexcept;

   private:
    struct Group {
        Eigen::Matrix3d target, stiffness;
        int begin, end;  ///< of its nodes
    };
    struct Hardening {
        double s, rise, bend;
        Eigen::Vector3d pull, slope;  ///< K gap of the first group, and what is added to it
    };
    Eigen::Vector3d gap(const Group& group, const Eigen::Vector3d& push, const NodeColumns& u) const noexcept;
    Eigen::Vector3d tissue(const Group& group, const NodeColumns& u) const noexcept;
    Hardening hardened(const Eigen::Vector3d& gap) const noexcept;
    Eigen::Matrix3d curvature(const Eigen::Vector3d& push, const NodeColumns& u) const noexcept;
    Eigen::Vector3d in_space(const Point& p) const noexcept;

    int dimension_ = 2, groups_ = 0, nodes_ = 0;
    Eigen::Vector3d inward_ = Eigen::Vector3d::Zero();
    double hardening_1_J_ = 0, saturation_1_J_ = 0, coupling_N_m2_ = 0;
    Group group_[most_nodes + 1];
    int node_[2 * most_nodes];
    double weight_[2 * most_nodes];
};

}  // namespace tissue
