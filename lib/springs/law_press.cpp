#include "springs/law_press.h"

#include "error.h"

namespace tissue {

LawPress::LawPress(const SpringMesh& mesh, LawModel law)
    : law_(std::move(law)), energy_(mesh, law_.incompressible), surface_(mesh) {}

Equilibrium LawPress::at(double arc_m, const Eigen::Vector2d& push_m) const {
    const ContactPatch patch = surface_.at(arc_m);
    PressSolver solver(energy_, surface_);
    try {
        const PressState state = solver.press(law_.constants, {patch, law_.patch.at(patch)}, push_m);
        const EquilibriumStatus status = state.status == PressStatus::held       ? EquilibriumStatus::balanced
                                         : state.status == PressStatus::unstable ? EquilibriumStatus::unstable
                                                                                 : EquilibriumStatus::not_converged;
        return {state.displacement, state.contact_force_N, status};
    } catch (const MismatchError&) {  // nothing to push there
        return {NodeField::Zero(energy_.node_count(), 2), Eigen::VectorXd::Zero(2), EquilibriumStatus::contact_fixed};
    }
}

}  // namespace tissue
