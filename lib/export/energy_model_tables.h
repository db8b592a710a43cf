#pragma once

#include <optional>
#include <string>
#include <vector>

#include "springs/indentation_solver.h"

namespace tissue {

/// Energy of an energy model in the plane as tables, to be evaluated without this program (results/FORMATS.md):
///   W(u) = sum_s theta_s w(l_s, L_s) + sum_e A_e a_e (area_e / a_e - 1)^2 / 2
/// The first sum is over springs, with w of their force curve ((l - L)^2 / 2 for Hooke's). The second is over areas,
/// cells first and then regions: area_e = sum over the edges (i, j) of e of (x_i y_j - x_j y_i) / 2, and a_e is area_e
/// at rest.
struct EnergyModelTables {
    SpringCurve curve;
    /// of each edge: its area, first and last node, with the area on the left (K)
    std::vector<int> edge_area, edge_from, edge_to;
    std::vector<std::string> area_kind;              ///< "cell" or "region"
    Eigen::VectorXd area_m2;                         ///< a_e
    Eigen::VectorXd spring_N_m, area_N_m;            ///< theta_s, A_e: the model's constants
    std::vector<int> surface_node;                   ///< of the free surface, from one fixed end to the other
    std::vector<double> surface_arc_m;               ///< arc length of these nodes along it
    std::vector<double> surface_log_scale;           ///< log of the contact stiffness ratio, if adapted; else 0
};

/// The tables of a model, which must have an energy model in the plane. In space: export/solid_model_tables.h.
EnergyModelTables energy_model_tables(const TissueModel& model);

/// Equilibrium of the energy model at one of its load cases, under the disc of that case.
struct IndentationOfCase {
    int load_case;
    std::optional<double> arc_m;  ///< arc length of the contact along the free surface; in the plane
    Point push_m;
    Equilibrium state;         ///< of mesh and contact together, including the compliance of the contact
    NodeField force_N;         ///< dW/du, the external force on each node (N x D)
};

/// The load case called `name`, or all load cases if `name` is empty. Throws MismatchError for a name that is not in
/// the model.
std::vector<IndentationOfCase> indentations_of_cases(const TissueModel& model, const std::string& name);

}  // namespace tissue
