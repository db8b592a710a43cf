#pragma once

#include <Eigen/SparseCore>
#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// Unknowns x (P) of an energy model that is adapted to measurements; x = 0 is the trained model. x is added, through
/// the matrices below, to the logarithms of the constants and of the contact stiffnesses; both stay positive.
struct Unknowns {
    std::string kind;              ///< scale, terms, field, elements
    std::vector<std::string> terms;  ///< kind `terms`: names (P); else empty
    NodeField place_m;             ///< kinds `field` and `elements`: place of each unknown (P x D); else no rows
    using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
    Rows by_constant;              ///< d log constant / dx (E x P)
    Rows by_node;                  ///< d log contact stiffness at a node / dx (N x P)
    std::vector<Eigen::MatrixXd> by_patch;  ///< kind `terms`: d ContactParameters::log_N_m / dx (P of K x F); else empty
    Eigen::MatrixXd prior;         ///< covariance of x before the first measurement (P x P)

    Eigen::Index size() const { return prior.rows(); }
};

/// Prior standard deviations of the log stiffness of the target tissue over the training tissue.
struct PriorOptions {
    double common = 1;       ///< of a uniform change: a factor of 2.7 or 1 / 2.7
    double local = 0.5;      ///< of a local change, with correlation exp(-d^2 / (2 length_m^2)) at distance d
    double length_m = 0;     ///< correlation length; 0: two spacings of the surface's nodes
    double term = 0.3;       ///< of the coefficient of a term
};

/// Unknowns of a model, by kind:
///   scale     one for the whole tissue
///   terms     one uniform scale, and the coefficients of the model's terms without those of skin and disc size
///   field     one for each node (embedded solid: each node of the lattice); an element has the mean of its nodes, a
///             contact the weighted mean of its nodes
///   elements  one for each element (spring, cell, region, support) at its centre, and one for each node for contacts
/// Throws MismatchError for another kind and for a model without an energy model; for kind `terms` also where a term
/// depends on an inclusion (nodule, ground), which only the study defines, or does not fit the mesh.
Unknowns make_unknowns(const TissueModel& model, const std::string& kind, const PriorOptions& options = {});
const std::vector<std::string>& unknown_kinds();

/// The energy model with the unknowns x (P) applied.
EnergyModel with_unknowns(const EnergyModel& energy_model, const Unknowns& unknowns, const Eigen::VectorXd& x);

}  // namespace tissue
