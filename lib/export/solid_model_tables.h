#pragma once

#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// Energy of an energy model in space as tables, as EnergyModelTables in the plane (results/FORMATS.md):
///   W(u) = sum_s theta_s w(l_s, L_s) + sum_c A_c V_c (J_c(u) - 1)^2 / 2 + sum_m k_m |u_m|^2 / 2
/// The sums are over springs, cells and supports. J_c is the determinant of the deformation gradient of the cell's
/// trilinear map at `at`; along each axis the gradient is the mean of the cell's four edges with bilinear weights. A
/// support fixes a node of an embedded solid elastically; u_m is interpolated from the corners of a cell.
struct SolidModelTables {
    SpringCurve curve;           ///< of w
    Eigen::VectorXd spring_N_m;  ///< theta_s
    Cells cells;                 ///< corner numbers in binary: 1 along x, 2 along y, 4 along z (C x 8)
    /// place of J_c (C x 3), from corner 0 in edge lengths: the middle, or the centroid of the tissue in a cut cube
    NodeField at;
    Eigen::VectorXd volume_m3;   ///< V_c
    Eigen::VectorXd cell_Pa;     ///< A_c
    Eigen::VectorXd support_N_m; ///< k_m of the mesh's fixed nodes; empty for a block (M)
};

/// Contact rows of several load cases, one case after the other. With e_r = push_r . d - sum of pull . u over the nodes
/// of row r,
///   E(d, u) = sum_r k_r e_r^2 / 2 + hardening s^2 / (2 (1 + saturation s)) + coupling e_0 (e_1^2 + e_2^2) / 2,
///   with the changes of springs/contact_coupling.h where it hardens in compression alone
/// where s = sum of k_r e_r^2 / 2 over the case's first three rows, and e_0, e_1, e_2 are of these rows.
struct ContactTable {
    std::vector<int> load_case;      ///< of each row (R)
    std::vector<std::string> kind;   ///< normal, tangent, imprint_normal or imprint_tangent (R)
    std::vector<double> k_N_m;       ///< (R)
    NodeField push;                  ///< (R x 3)
    std::vector<int> pull_row, pull_node;  ///< row and node of each nonzero entry (Q)
    NodeField pull;                  ///< (Q x 3)
    /// per load case: hardening, saturation [1/J], coupling [N/m2], and 1 where it hardens in compression alone, else 0
    NodeField hardening;
};

/// The tables of a model, which must have an energy model in space.
SolidModelTables solid_model_tables(const TissueModel& model);

/// Contact rows of load cases of such a model, each under its own disc. A case without tissue of the lattice near its
/// contact has no rows. Throws MismatchError for a disc outside the range of the model's (energy_model_at_radius).
ContactTable contact_table(const TissueModel& model, const std::vector<int>& load_cases);

}  // namespace tissue
