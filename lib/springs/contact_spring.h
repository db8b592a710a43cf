#pragma once

#include "springs/contact_patch.h"

namespace tissue {

/// One contact's energy, for training and evaluation. With k_r = share_r times the law's stiffness,
///   E = sum_r k_r e_r^2 / 2 + hardening s^2 / (2 (1 + saturation s)) + coupling e_0 (e_1^2 + e_2^2) / 2
/// of a disc, s the part of the sum that its mean rows have (0 to 2). They harden by their energy, whatever the direction: what
/// lies between tool and mesh stiffens as it is pressed together, the less the further it has gone. Where the mesh stiffens more than the
/// tissue does the contact softens instead, hardening -v and saturation v: to half its stiffness at most, (1 + v s + (v s)^2 / 2) /
/// (1 + v s)^2 of it, so that more energy always takes more push. The imprint does not: at
/// any depth it is the disc's own shape. Dragged sideways (mean rows 1 and 2) it presses back (mean row 0): in a
/// sheared rubber normal stress goes with the square of the shear (Poynting).
struct ContactSpring {
    ContactRows rows;
    Eigen::VectorXd law_value;    ///< of each of the law's rows, scaled (K); empty of the tick's
    Eigen::VectorXd k_N_m;        ///< (R)
    double hardening_1_J = 0, saturation_1_J = 0, coupling_N_m2 = 0;
    bool softens = false;         ///< hardening is minus saturation, and both are the law's row hardening

    ContactSpring(ContactRows where, const PatchLaw& law);
    ContactSpring(const PatchSpring& patch);  ///< the same energy as the tick has it

    struct Load {
        double energy_J;
        Point hand_N;             ///< dE/dd: force of the tool on the tissue (D)
        Eigen::VectorXd node_N;   ///< dE/du: what the contact asks of the rest to hold u (D*K)
    };
    /// u: of the rows' nodes (D*K) [m].
    Load load(const Point& push_m, const Eigen::VectorXd& u) const;

    Eigen::MatrixXd tangent(const Point& push_m, const Eigen::VectorXd& u) const;        ///< d node / du (D*K x D*K)
    Eigen::MatrixXd hand_by_nodes(const Point& push_m, const Eigen::VectorXd& u) const;  ///< d hand / du (D x D*K)
    /// Derivatives of all three by law_value m.
    Load by_law_row(int m, const Point& push_m, const Eigen::VectorXd& u) const;

    /// Size of the stiffness against d with the nodes held [N/m].
    double push_N_m() const { return (rows.push.transpose() * k_N_m.asDiagonal() * rows.push).norm(); }

    Eigen::VectorXd gather(const NodeField& u) const;  ///< of the rows' nodes (D*K)

   private:
    struct State;  ///< what an e makes of the energy
    Eigen::MatrixXd curvature_pull(const Point& push_m, const Eigen::VectorXd& u) const;
};

}  // namespace tissue
