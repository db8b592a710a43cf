#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "field.h"

namespace tissue {

/// Trained parameters of the skin at a disc (SkinNode), 0 before training.
using SkinLaw = Eigen::Vector4d;
/// Their terms, in that order: skin.normal, skin.tangent, skin.heave, skin.radial.
const std::array<std::string, 4>& skin_terms();
bool is_skin_term(const std::string& term);
/// Where they stand among a law's terms; -1 where they do not.
std::array<Eigen::Index, 4> skin_columns(const std::vector<std::string>& terms);
/// The parameters of the skin among a law's.
SkinLaw skin_of(const std::vector<std::string>& terms, const Eigen::VectorXd& coefficients);

/// Displacement of a node of the free surface, as it is drawn and compared with FE. Springs as long as a disc is wide cannot resolve the surface
/// beside it, but the tool's displacement d is known. With x = r / R, phi and the displacement A of a half space's surface per d
/// (DiscContact::target_at), n inward, t the part of the way from the contact to the node that runs along the surface, over r:
///   x <= 1        phi(x) d: the disc does not slip
///   1 < x < 2.5   (1 - w) u + w A d + (x - 1) w (c_normal n n'd + c_tangent (d - n n'd) + c_heave n t'd + c_radial t n'd),
///                 w = ((2.5 - x) / 1.5)^2
///   beyond        u, the lattice's own
/// Continuous in the contact's place and in d. It begins and ends with the contact: when the tool leaves a surface that is still dented, the shown displacement becomes the
/// lattice's within one tick. Forces and equilibria do not depend on it, and adaptation does not change it. Exported displacements (CSV, VTU) are the lattice's, which balance the
/// exported forces; VTP and glTF have what is seen.
struct SkinNode {
    int node;
    double keep;                         ///< 1 - w
    Eigen::Matrix3d push;                ///< w A
    std::array<Eigen::Matrix3d, 4> by;   ///< d push / d c

    Eigen::Vector3d shown(const Eigen::Vector3d& u, const SkinLaw& c, const Eigen::Vector3d& d) const noexcept {
        return keep * u + (push + c[0] * by[0] + c[1] * by[1] + c[2] * by[2] + c[3] * by[3]) * d;
    }
};

}  // namespace tissue
