#pragma once

#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// A law's energy in space as tables, as LawTables in the plane (results/FORMATS.md):
///   W(u) = sum_s theta_s w(l_s, L_s) + sum_c A_c V_c (J_c(u) - 1)^2 / 2 + sum_m k_m |u_m|^2 / 2
/// over springs, cells and supports; J_c the determinant of the deformation gradient of the trilinear map at `at` in the cell, which along each axis is the mean of
/// its four edges with bilinear weights. A support holds a node of an embedded solid, whose u is that of a cell's corners with weights.
struct SolidLawTables {
    SpringCurve curve;           ///< of w
    Eigen::VectorXd spring_N_m;  ///< theta_s
    Cells cells;                 ///< corners bit by bit: 1 along x, 2 along y, 4 along z (C x 8)
    NodeField at;                ///< from corner 0, in edges: the middle, or the centroid of a cut cube's tissue (C x 3)
    Eigen::VectorXd volume_m3;   ///< V_c
    Eigen::VectorXd cell_Pa;     ///< A_c
    Eigen::VectorXd support_N_m; ///< k_m, of the mesh's fixed nodes; empty of a block (M)
};

/// What contacts take of push and displacement, of several load cases one after the other: with e_r = push_r . d - sum of
/// pull . u over the row's nodes, and s = sum_r k_r e_r^2 / 2,
///   E(d, u) = s + hardening s^2 / (2 (1 + saturation s)) + coupling e_0 (e_1^2 + e_2^2) / 2
/// e_0, e_1, e_2 those of the case's first three rows.
struct ContactTable {
    std::vector<int> load_case;      ///< of each row (R)
    std::vector<std::string> kind;   ///< normal, tangent, imprint_normal or imprint_tangent (R)
    std::vector<double> k_N_m;       ///< (R)
    NodeField push;                  ///< (R x 3)
    std::vector<int> pull_row, pull_node;  ///< of each entry that is not zero (Q)
    NodeField pull;                  ///< (Q x 3)
    NodeField hardening;             ///< of each load case asked for: hardening, saturation [1/J], coupling [N/m2]
};

/// The model must have a law, in space.
SolidLawTables solid_law_tables(const TissueModel& model);

/// Of load cases of such a model, each under its own disc. One that has nothing to push has no rows.
ContactTable contact_table(const TissueModel& model, const std::vector<int>& load_cases);

}  // namespace tissue
