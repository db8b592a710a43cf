#pragma once

#include <memory>
#include <string>
#include <vector>

#include "springs/contact_spring.h"
#include "springs/sparse_factor.h"
#include "springs/tissue_energy.h"

namespace tissue {

/// How the search for a pressed tissue's rest ended. g: the energy's derivative by the free displacements,
/// H: its second one, the contacts' included; |F|: of the tool's force, of several tools the sum; a: TissueEnergy::smallest_ratio.
enum class PressStatus {
    held,        ///< max |g| <= tolerance |F|, every pivot of H > 0, and a > 0: a minimum of the energy
    unstable,    ///< max |g| <= tolerance |F|, a pivot <= 0: an equilibrium that the least touch upsets
    inside_out,  ///< max |g| <= tolerance |F|, every pivot > 0, a <= 0: a minimum that no tissue can have
    lost         ///< no load step down to smallest_step of the push led to max |g| <= tolerance |F|
};
const char* to_string(PressStatus status);

struct PressOptions {
    double load_step = 0.25;       ///< longest load step over the mean spacing of the surface's nodes: 10 mm in four steps
    double smallest_step = 1e-3;   ///< part of the push below which no load step begins or is halved again
    int max_newton = 15;           ///< a load step; measured: 3-5 are taken
    double tolerance = 1e-10;
    double solid_load_step = 1;    ///< load_step in space, where a disc spreads what it does
};

/// A tool's contact, and how far it is pushed.
struct PressedTool {
    ContactSpring contact;
    Point push_m;  ///< d (D)
};

/// Rest of the tissue while one tool, or several, hold their contacts at pushes.
struct PressState {
    PressStatus status = PressStatus::held;
    NodeField displacement;                                   ///< u [m] (N x D)
    Point push_m;                                             ///< d of the first tool, as far as it was reached (D)
    Point contact_force_N;                                    ///< of that tool on the tissue: dW/dd, what a hand feels (D)
    double energy_J = 0;                                      ///< W, the contacts' own included
    int newton = 0;                                           ///< iterations, all load steps together
    struct OtherTool {
        Point push_m, contact_force_N;
    };
    std::vector<OtherTool> others = {};                       ///< the same of further tools, in their order
};

/// Derivatives of a PressState by P parameters, at a held push.
struct PressDerivative {
    Eigen::MatrixXd displacement;   ///< [m] (N*D x P)
    Eigen::MatrixXd contact_force;  ///< [N] (D x P)
};

/// What a PressState's contact force alone changes by, of everything that makes it, at a held push.
struct ForceDerivative {
    Eigen::MatrixXd by_constant;  ///< of the energy [m] (D x E)
    Eigen::MatrixXd by_law_row;   ///< by ContactSpring::law_value (D x K)
};

/// Finds the displacement that makes tissue and contact energy smallest, contact by contact: Newton with load steps,
/// each from the equilibrium before, halved when lost (springs/sparse_factor.h). The pattern is made once where the kernel knows what its
/// contacts couple, else once for every contact that follows another. One object a thread.
class PressSolver {
   public:
    /// Both must outlive the solver.
    PressSolver(const TissueEnergy& energy, const ContactKernel& kernel, const PressOptions& options = {});

    /// From rest, or from another push of the same contact; a rest of other constants at this very push is a first guess. A
    /// lost push comes back as far as it was reached. Throws FixedContactError when all nodes of the patch are fixed: there is nothing to push.
    PressState press(const Eigen::VectorXd& constants, const ContactSpring& contact, const Point& push_m,
                     const PressState* from = nullptr) {
        return press(constants, {{contact, push_m}}, from);
    }

    /// The same of several tools, one at least, all pushed in proportion. `from` has the same tools in their order; those that it does not have come from no push.
    PressState press(const Eigen::VectorXd& constants, std::vector<PressedTool> tools, const PressState* from = nullptr);

    /// du/dp = -H^-1 dg/dp at the state that the last press() ended with, of one tool (else MismatchError), held there: constants_by (E x P) and
    /// stiffness_by (K x P: the rows of PatchLaw) say how the constants depend on p. Implicit
    /// function theorem; no tangent is solved for again.
    PressDerivative derivative(const Eigen::MatrixXd& constants_by, const Eigen::MatrixXd& stiffness_by) const;

    /// The force's part of it, of all constants at once: the adjoint of the same, D solves whatever their number.
    ForceDerivative force_derivative() const;

   private:
    bool balance(const Eigen::VectorXd& constants, NodeField& u, int& iterations);
    double out_of_balance(const Eigen::VectorXd& constants, const NodeField& u, Eigen::VectorXd& g) const;
    bool factorise(const Eigen::VectorXd& constants, const NodeField& u);
    const PressedTool& the_tool() const;
    double* entry(int row, int column);
    void lay_out(const std::vector<std::pair<int, int>>& coupled);
    void make_room();

    const TissueEnergy& energy_;
    PressOptions options_;
    double spacing_m_;                      ///< of the surface's nodes
    bool every_contact_;                    ///< the pattern has room for contacts anywhere
    std::vector<std::vector<int>> room_for_;  ///< else: for each tool's nodes together
    std::vector<int> number_;               ///< of each degree of freedom among the free ones, -1 held (N*D)
    int free_ = 0;
    Eigen::SparseMatrix<double> H_;         ///< lower triangle; its pattern holds every contact, or the last
    std::vector<std::vector<int>> slots_;   ///< by kind: where each entry of each element's tangent goes, -1 nowhere
    SparseFactor factor_;
    std::vector<PressedTool> tools_;        ///< as they are pushed now; after press() where it ended
    NodeField u_;                           ///< where the last press() ended
};

}  // namespace tissue
