#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/force_error.h"
#include "springs/ball_press.h"
#include "springs/equilibrium.h"
#include "springs/law_press.h"

namespace tissue {

/// A contact at which FE knows what becomes of the tissue: where, how far pushed, and the answer.
struct ContactTruth {
    SurfacePoint contact;           ///< in the plane
    Eigen::VectorXd push_m;         ///< d (D)
    Eigen::VectorXd force_N;        ///< r_fe (D)
    NodeField displacement_m = {};  ///< u_fe (N x D); empty where it was not seen, as inside measured tissue
};

/// What a model of any kind says of a contact held at d.
struct ContactAnswer {
    std::optional<Eigen::VectorXd> force_N;  ///< r_model (D); nothing without an answer
    NodeField displacement_m = {};           ///< u_model (N x D), as it is seen; empty where the model has a force alone
    std::string reason = {};                 ///< why there is no answer, for people; empty where nothing failed
};

/// How far an answer is from the truth, to a hand and to an eye. Infinity where the model has no answer (eval/statistics.h); absent where
/// there is nothing to compare: the truth has no force or was not seen, or the model has a force alone.
struct ContactError {
    std::optional<double> force;                 ///< |r_model - r_fe| / |r_fe|
    std::optional<double> shape;                 ///< rms of u_model - u_fe over rms of u_fe, both over the free nodes, in
                                                 ///< space over those of the surface
    std::optional<double> shape_max_over_depth;  ///< largest |u_model - u_fe| of such a node, over |d|
    std::string reason = {};                     ///< the answer's, or why no error is relative to the truth
};

/// The mesh says which nodes are free. Shape is absent where answer or truth has no displacement. Any topology will do:
/// nodes are compared one by one. seen: those that count (seen_nodes of mesh/free_surface.h).
ContactError error_of(const ContactAnswer& answer, const ContactTruth& truth, const SpringMesh& mesh, const std::vector<int>& seen);
ContactError error_of(const ContactAnswer& answer, const ContactTruth& truth, const SpringMesh& mesh);

/// The spring mesh at equilibrium: the contact held where the truth has it, everything else at rest.
ContactAnswer answer_of(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                        const ContactTruth& truth);

/// The same of any model's rest.
ContactAnswer answer_of(const Equilibrium& state);

/// The law pressed there, from rest, as it is seen (LawPress::seen). radius_m: of the disc, 0 the law's own; one that the law does not know has no answer.
ContactAnswer answer_of(const LawPress& law, const Point& contact_m, const Point& push_m, double radius_m = 0);
/// The same of a rigid ball; a push whose contact is larger than the law knows has no answer.
ContactAnswer answer_of(const BallPress& ball, const Point& contact_m, const Point& push_m);

/// Errors of one model at many contacts.
struct ContactStatistics {
    Statistics force, shape, shape_max_over_depth;
    std::string reasons;  ///< why others have no answer, each with how many, on one line; empty when all have one
};
/// lost: how many contacts more were asked for at which FE has no answer.
ContactStatistics contact_statistics(const std::vector<ContactError>& errors, int lost = 0);

/// The honest baseline: the one stiffness for the whole mesh [N/m] (diagonals half) with the smallest median
/// closed-loop force error over `truths`, found on a logarithmic grid of 1 % steps between low and high [N/m].
/// A contact without an equilibrium, whatever the stiffness, counts as an infinite error; nothing where the median is infinite.
/// Contacts without a force are left out.
std::optional<double> best_uniform_stiffness(const SpringMesh& mesh, const SpringLaw& law,
                                             const std::vector<ContactTruth>& truths, double low_N_m, double high_N_m);

}  // namespace tissue
