#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "field.h"

namespace tissue {

/// Trained parameters of the displayed surface at a disc (SkinNode); 0 before training.
using SkinParameters = Eigen::Vector4d;
/// Names of their terms, in that order: skin.normal, skin.tangent, skin.heave, skin.radial.
const std::array<std::string, 4>& skin_terms();
bool is_skin_term(const std::string& term);
/// Index of each among the terms of a model; -1 where it is missing.
std::array<Eigen::Index, 4> skin_columns(const std::vector<std::string>& terms);
/// Skin parameters among the coefficients of a model's terms; 0 where a term is missing.
SkinParameters skin_of(const std::vector<std::string>& terms, const Eigen::VectorXd& coefficients);

/// Displacement of a free-surface node for display and for comparison with FE. Springs as long as the disc's width
/// cannot resolve the surface around it, but the tool's displacement d is known there. With x = r / R, phi and A, the
/// displacement of a half space's surface per d (target_at() in disc_contact.cpp), the inward normal n, and t, the
/// tangential part of the vector from contact to node over r:
///   x <= 1        phi(x) d: the disc does not slip
///   1 < x < 2.5   (1 - w) u + w A d
///                 + (x - 1) w (c_normal n n'd + c_tangent (d - n n'd) + c_heave n t'd + c_radial t n'd),
///                 w = ((2.5 - x) / 1.5)^2
///   beyond        u of the lattice
/// The result is continuous in the contact's place and in d. It exists only during contact: when the tool leaves a
/// surface that is still deformed, the displayed displacement becomes the lattice's within one tick. Forces and
/// equilibria do not depend on it, and adaptation does not change it. Exported displacements in CSV and VTU are the
/// lattice's, which balance the exported forces. VTP and glTF contain the displayed ones.
struct SkinNode {
    int node;
    double keep;                         ///< 1 - w
    Eigen::Matrix3d push;                ///< w A
    std::array<Eigen::Matrix3d, 4> by;   ///< d push / d c

    Eigen::Vector3d shown(const Eigen::Vector3d& u, const SkinParameters& c, const Eigen::Vector3d& d) const noexcept {
        return keep * u + (push + c[0] * by[0] + c[1] * by[1] + c[2] * by[2] + c[3] * by[3]) * d;
    }
};

}  // namespace tissue
