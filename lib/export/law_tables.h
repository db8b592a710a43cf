#pragma once

#include <optional>
#include <string>
#include <vector>

#include "springs/law_press.h"

namespace tissue {

/// A law's energy as tables, so that whoever reads them can work it out without this program (results/FORMATS.md):
///   W(u) = sum_s theta_s w(l_s, L_s) + sum_e A_e a_e (area_e / a_e - 1)^2 / 2
/// over springs, w of their curve, (l - L)^2 / 2 of Hooke's, and over areas, cells first and then regions; area_e = sum over the edges (i, j) of e of
/// (x_i y_j - x_j y_i) / 2, a_e at rest.
struct LawTables {
    SpringCurve curve;
    std::vector<int> edge_area, edge_from, edge_to;  ///< of each edge: its area, and nodes, the area on the left (K)
    std::vector<std::string> area_kind;              ///< cell or region
    Eigen::VectorXd area_m2;                         ///< a_e
    Eigen::VectorXd spring_N_m, area_N_m;            ///< theta_s, A_e: the law's constants
    std::vector<int> surface_node;                   ///< of the free surface, from one held end to the other
    std::vector<double> surface_arc_m;               ///< and where along it
    std::vector<double> surface_log_scale;           ///< of contacts there, of a law that has learned from pokes; else 0
};

/// The model must have a law, in the plane; in space: export/solid_law_tables.h.
LawTables law_tables(const TissueModel& model);

/// The law's answer at a load case of the model, under that case's disc.
struct PressedCase {
    int load_case;
    std::optional<double> arc_m;  ///< of the contact, along the free surface; in the plane
    Point push_m;
    Equilibrium state;         ///< of the whole, the contact's own compliance included
    NodeField force_N;         ///< dW/du: what holds the tissue there (N x D)
};

/// Of the case called `name`, or of all where it is empty. Throws MismatchError for a name that is not in the model.
std::vector<PressedCase> pressed_cases(const TissueModel& model, const std::string& name);

}  // namespace tissue
