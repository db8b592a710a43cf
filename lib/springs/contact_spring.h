#pragma once

#include "springs/contact_patch.h"

namespace tissue {

/// Energy of one contact, for training and evaluation. With k_r = share_r times the stiffness of the row's ContactParameters
/// row,
///   E = sum_r k_r e_r^2 / 2 + hardening s^2 / (2 (1 + saturation s)) + coupling e_0 (e_1^2 + e_2^2) / 2,
/// where the last two terms are of a disc, and s is the part of the sum from its mean rows (0 to 2).
/// - Hardening: what lies between tool and mesh stiffens under compression. It depends on the energy s, thus not on the
///   direction, and saturates as s grows.
/// - Hardening in compression only (ContactCurve::compression): s = k_0 e_0^2 / 2 for e_0 > 0, else 0. The FE force of a
///   disc that pulls or moves along the surface does not harden.
/// - Softening replaces hardening where the mesh stiffens more than the tissue does: hardening -v and saturation v. The
///   stiffness is multiplied by (1 + v s + (v s)^2 / 2) / (1 + v s)^2, which is never below 1/2. The energy therefore
///   always increases with the displacement.
/// - The imprint rows do not harden: at any depth they impose the disc's own shape.
/// - Coupling: a tangential displacement (mean rows 1 and 2) causes a normal force (mean row 0). In sheared rubber the
///   normal stress is proportional to the square of the shear (Poynting). Where the contact hardens in compression only,
///   s(e_0) of springs/contact_coupling.h stands in place of e_0, so that the energy of a tool that pulls is convex.
struct ContactSpring {
    ContactRows rows;
    Eigen::VectorXd parameter_value;    ///< value of each ContactParameters row, scaled (K); empty where made from a PatchSpring
    Eigen::VectorXd k_N_m;        ///< stiffness of each row (R)
    double hardening_1_J = 0, saturation_1_J = 0, coupling_N_m2 = 0;
    ContactCurve curve = ContactCurve::hardens;  ///< softens: hardening = -saturation, both from the ContactParameters row hardening

    ContactSpring(ContactRows where, const ContactParameters& contact_parameters);
    ContactSpring(const PatchSpring& patch);  ///< the same energy as the tick's form in the plane

    struct Load {
        double energy_J;
        Point tool_force_N;             ///< dE/dd: force of the tool on the tissue (D)
        Eigen::VectorXd node_N;   ///< dE/du: nodal forces that hold u against the contact (D*K)
    };
    /// push_m: tool displacement d [m] (D). u: displacements of the rows' nodes [m] (D*K).
    Load load(const Point& push_m, const Eigen::VectorXd& u) const;

    Eigen::MatrixXd tangent(const Point& push_m, const Eigen::VectorXd& u) const;        ///< d node_N / du (D*K x D*K)
    Eigen::MatrixXd tool_force_by_nodes(const Point& push_m, const Eigen::VectorXd& u) const;  ///< d tool_force_N / du (D x D*K)
    Eigen::MatrixXd tool_force_by_push(const Point& push_m, const Eigen::VectorXd& u) const;   ///< d tool_force_N / dd (D x D)
    /// Derivatives of all three members of Load by parameter_value[m].
    Load by_parameter_row(int m, const Point& push_m, const Eigen::VectorXd& u) const;

    /// Norm of the linear stiffness against d at fixed nodes [N/m].
    double push_N_m() const { return (rows.push.transpose() * k_N_m.asDiagonal() * rows.push).norm(); }

    Eigen::VectorXd gather(const NodeField& u) const;  ///< displacements of the rows' nodes (D*K)

   private:
    /// Bound of ContactCoupling [1/m].
    double coupling_bound() const { return curve == ContactCurve::compression ? 2 * coupling_N_m2 / k_N_m[1] : 0; }
    struct State;  ///< quantities derived from e
    Eigen::MatrixXd curvature_times(const Eigen::MatrixXd& e_by, const Point& push_m, const Eigen::VectorXd& u) const;
};

}  // namespace tissue
