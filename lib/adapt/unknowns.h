#pragma once

#include <Eigen/SparseCore>
#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// What may become another of a law that learns from pokes: P numbers x, all 0 where the law is as it was trained. Each adds its part to
/// the logarithm of the law's constants and of its contacts' stiffnesses, so that both stay positive whatever x.
struct Unknowns {
    std::string kind;              ///< scale, terms, field, elements
    std::vector<std::string> terms;  ///< of `terms` (P); else none
    NodeField place_m;             ///< of `field`, of `elements`: where each lies (P x D); else no rows
    using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
    Rows by_constant;              ///< d log constant / dx (E x P)
    Rows by_node;                  ///< d log scale of contacts at a node / dx (N x P)
    std::vector<Eigen::MatrixXd> by_patch;  ///< of `terms`: d PatchLaw::log_N_m / dx (P of K x F); else none
    Eigen::MatrixXd prior;         ///< covariance of x before the first poke (P x P)

    Eigen::Index size() const { return prior.rows(); }
};

/// How far a tissue may be from the one that was trained on, in standard deviations of log stiffness.
struct PriorOptions {
    double common = 1;       ///< of all of it together: a factor of 2.7 either way
    double local = 0.5;      ///< of a place beside the rest,
    double length_m = 0;     ///< which is alike over so far, as exp(-d^2 / 2 length^2); 0: two spacings of the surface's nodes
    double term = 0.3;       ///< of a term's coefficient
};

/// By kind:
///   scale     one number for all there is
///   terms     the law's own coefficients, beside a scale
///   field     one a node: an element has the mean of its nodes, a contact that of those it rests on
///   elements  one a spring, cell and region at its middle, and one a node for contacts
/// Throws MismatchError for another kind, a model without a law, and terms of a law that were not trained on this mesh.
Unknowns make_unknowns(const TissueModel& model, const std::string& kind, const PriorOptions& options = {});
const std::vector<std::string>& unknown_kinds();

/// The law with x taken.
LawModel with_unknowns(const LawModel& law, const Unknowns& unknowns, const Eigen::VectorXd& x);

}  // namespace tissue
