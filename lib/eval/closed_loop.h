#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/force_error.h"
#include "springs/ball_indentation.h"
#include "springs/equilibrium.h"
#include "springs/indentation_solver.h"

namespace tissue {

/// FE reference at one contact: tool displacement, force and displacement field.
struct ContactReference {
    SurfacePoint contact;           ///< on the free surface; two dimensions only
    Eigen::VectorXd push_m;         ///< tool displacement d [m] (D)
    Eigen::VectorXd force_N;        ///< force of the tool on the tissue r_fe [N] (D)
    NodeField displacement_m = {};  ///< u_fe [m] (N x D); empty for measured tissue, where only the force is known
};

/// Answer of one model at one contact with tool displacement d.
struct ContactAnswer {
    std::optional<Eigen::VectorXd> force_N;  ///< r_model [N] (D); absent without an answer
    /// u_model [m] (N x D), under a disc with its skin (IndentationSolver::displayed); empty: force only.
    NodeField displacement_m = {};
    std::string reason = {};                 ///< why there is no answer; empty with an answer
};

/// Indentation errors of one answer against the FE reference. Infinity: the model has no answer (eval/statistics.h).
/// Absent: there is nothing to compare, because the reference has no force or no displacement field, or the model
/// predicts a force only.
struct ContactError {
    std::optional<double> force;                 ///< |r_model - r_fe| / |r_fe|
    /// rms of u_model - u_fe over rms of u_fe, over the free nodes; in space over the free nodes of the surface.
    std::optional<double> shape;
    std::optional<double> shape_max_over_depth;  ///< largest |u_model - u_fe| of such a node, over |d|
    std::string reason = {};                     ///< ContactAnswer::reason, or why no relative error is defined
};

/// Indentation errors of force and displacement. mesh: gives the fixed nodes, which are left out; its topology does not
/// matter. compared: nodes that are compared, one by one (compared_nodes of mesh/free_surface.h, the default).
ContactError error_of(const ContactAnswer& answer, const ContactReference& reference, const SpringMesh& mesh, const std::vector<int>& compared);
ContactError error_of(const ContactAnswer& answer, const ContactReference& reference, const SpringMesh& mesh);

/// Equilibrium of the spring mesh with the reference's tool displacement. law: spring force (10); theta [N/m] (S).
ContactAnswer answer_of(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                        const ContactReference& reference);

/// Force and displacement of an equilibrium, or the reason why there is none.
ContactAnswer answer_of(const Equilibrium& state);

/// Equilibrium of the energy model `law` at a contact [m] (D) with tool displacement push_m [m] (D), with the skin
/// (IndentationSolver::displayed). radius_m: radius of the disc [m]; 0: the model's own. There is no answer for a radius outside the
/// range that the model was trained under.
ContactAnswer answer_of(const IndentationSolver& solver, const Point& contact_m, const Point& push_m, double radius_m = 0);
/// The same for a rigid ball. There is no answer where the contact is larger than the largest disc of the training, or
/// the penetration depth larger than the effective radius R_e (springs/ball_contact.h).
ContactAnswer answer_of(const BallIndentation& ball, const Point& contact_m, const Point& push_m);

/// Indentation errors of one model over many contacts.
struct ContactStatistics {
    Statistics force, shape, shape_max_over_depth;
    std::string reasons;  ///< reasons of missing errors, each with its count, on one line; empty when there are none
};
/// lost: number of further contacts without an FE reference (Statistics::no_reference).
ContactStatistics contact_statistics(const std::vector<ContactError>& errors, int lost = 0);

/// Uniform baseline: the stiffness of all springs [N/m] (diagonals have half of it) with the smallest median
/// indentation error of force over `truths`. Searched on a logarithmic grid with steps of 1 % from low to high [N/m].
/// A contact without an equilibrium counts as an infinite error. Contacts without a force are left out. Result: absent
/// where the median is infinite.
std::optional<double> best_uniform_stiffness(const SpringMesh& mesh, const SpringLaw& law,
                                             const std::vector<ContactReference>& references, double low_N_m, double high_N_m);

}  // namespace tissue
