#pragma once

#include <memory>
#include <string>
#include <vector>

#include "springs/contact_spring.h"
#include "springs/sparse_factor.h"
#include "springs/tissue_energy.h"

namespace tissue {

/// Outcome of the search for the equilibrium of indented tissue. g: derivative of the energy by the free displacements;
/// H: second derivative; both include the contacts. |F|: sum of the norms of the tools' forces, each plus the force of
/// a displacement of 1e-4 of the nodes' spacing. a: TissueEnergy::smallest_ratio.
enum class SolverStatus {
    /// converged: max |g| <= tolerance |F|, every pivot of H > 0, and a > 0: a minimum of the energy
    converged,
    /// max |g| <= tolerance |F|, but a pivot <= 0: an unstable equilibrium
    unstable,
    /// max |g| <= tolerance |F|, every pivot > 0, but a <= 0: a minimum with an inverted cell
    inverted,
    /// no equilibrium found: no load step down to smallest_step of the displacement reached max |g| <= tolerance |F|
    no_equilibrium
};
const char* to_string(SolverStatus status);  ///< the word of files (results/FORMATS.md) and of Python

struct SolverOptions {
    /// in the plane: longest load step over the mean spacing of the surface's nodes; 10 mm spacing: 2.5 mm steps
    double load_step = 0.25;
    /// smallest load step, over the whole displacement: steps do not start smaller and are not halved below it
    double smallest_step = 1e-3;
    int max_newton = 15;           ///< iterations per load step; measured: 3-5 are needed
    double tolerance = 1e-10;
    /// load_step in space, where a disc distributes its load over more nodes
    double solid_load_step = 1;
};

/// Contact of a tool, and its displacement.
struct DisplacedTool {
    ContactSpring contact;
    Point push_m;  ///< d (D)
};

/// Equilibrium of the tissue with the displacements of one or several tools prescribed.
struct EquilibriumState {
    SolverStatus status = SolverStatus::converged;
    NodeField displacement;                                   ///< u [m] (N x D)
    /// displacement d of the first tool, as far as it was reached [m] (D)
    Point push_m;
    /// force of that tool on the tissue, dW/dd [N] (D)
    Point contact_force_N;
    double energy_J = 0;                                      ///< W, contacts included
    int newton = 0;                                           ///< iterations of all load steps together
    struct OtherTool {
        Point push_m, contact_force_N;
    };
    std::vector<OtherTool> others = {};                       ///< the same for further tools, in order
};

/// Derivatives of a EquilibriumState by P parameters, at prescribed tool displacement.
struct EquilibriumDerivative {
    Eigen::MatrixXd displacement;   ///< [m] (N*D x P)
    Eigen::MatrixXd contact_force;  ///< [N] (D x P)
};

/// Derivatives of the contact force alone by all constants and contact parameters, at prescribed tool displacement.
struct ForceDerivative {
    Eigen::MatrixXd by_constant;  ///< by each constant of the energy [m] (D x E)
    Eigen::MatrixXd by_parameter_row;   ///< by each ContactSpring::parameter_value (D x K)
};

/// Finds the displacement that minimises the energy of tissue and contacts. It uses Newton's method with load steps.
/// Each starts from the last equilibrium and is halved when it fails. Linear systems: springs/sparse_factor.h. The
/// matrix pattern is made once where the kernel gives all pairs that contacts couple, otherwise again for each contact
/// with other nodes. One object per thread.
class EquilibriumSolver {
   public:
    /// `energy` must outlive the solver.
    EquilibriumSolver(const TissueEnergy& energy, const ContactKernel& kernel, const SolverOptions& options = {});

    /// Starts from rest, or from the equilibrium `from` at another displacement of the same contact. `from` may also be
    /// an equilibrium of other constants at the same displacement; it is then a first guess. If a step fails, the
    /// result is the last equilibrium that was reached, with status `no_equilibrium`. Throws FixedContactError where all nodes of
    /// a contact are fixed.
    EquilibriumState indent(const Eigen::VectorXd& constants, const ContactSpring& contact, const Point& push_m,
                     const EquilibriumState* from = nullptr) {
        return indent(constants, {{contact, push_m}}, from);
    }

    /// The same for one or several tools, whose displacements grow in proportion. `from` has the first of these tools
    /// in the same order; the others start from zero displacement. Throws MismatchError for no tool, or if `from` has
    /// more tools.
    EquilibriumState indent(const Eigen::VectorXd& constants, std::vector<DisplacedTool> tools, const EquilibriumState* from = nullptr);

    /// du/dp = -H^-1 dg/dp at the state where the last indent() ended, at prescribed displacement (implicit function
    /// theorem). constants_by (E x P) and stiffness_by (K x P, the rows of ContactParameters): derivatives by p. It uses the
    /// last factorisation of H. Throws MismatchError for several tools.
    EquilibriumDerivative derivative(const Eigen::MatrixXd& constants_by, const Eigen::MatrixXd& stiffness_by) const;

    /// Derivative of the force alone by all constants, by the adjoint method: D solves, whatever their number. Throws
    /// MismatchError for several tools.
    ForceDerivative force_derivative() const;

   private:
    bool balance(const Eigen::VectorXd& constants, NodeField& u, int& iterations);
    double out_of_balance(const Eigen::VectorXd& constants, const NodeField& u, Eigen::VectorXd& g) const;
    bool factorise(const Eigen::VectorXd& constants, const NodeField& u);
    const DisplacedTool& the_tool() const;
    double* entry(int row, int column);
    void lay_out(const std::vector<std::pair<int, int>>& coupled);
    void make_room();

    const TissueEnergy& energy_;
    SolverOptions options_;
    double spacing_m_;                      ///< mean spacing of the surface's nodes [m]
    bool every_contact_;                    ///< the pattern has room for contacts anywhere
    /// otherwise it has room for contacts with these nodes, one list per tool
    std::vector<std::vector<int>> room_for_;
    /// number of each degree of freedom among the free ones; -1: dependent, as fixed (N*D)
    std::vector<int> number_;
    int free_ = 0;
    /// lower triangle; its pattern covers every contact, or the last
    Eigen::SparseMatrix<double> H_;
    /// by kind: position in H of each entry of each element's tangent; -1: none
    std::vector<std::vector<int>> slots_;
    SparseFactor factor_;
    /// at their current displacements; after indent() at those where it ended
    std::vector<DisplacedTool> tools_;
    NodeField u_;                           ///< displacement where the last indent() ended
};

}  // namespace tissue
