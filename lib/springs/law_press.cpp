#include "springs/law_press.h"

#include "error.h"

namespace tissue {
namespace {

EquilibriumStatus status_of(PressStatus status) {
    switch (status) {
        case PressStatus::held:
            return EquilibriumStatus::balanced;
        case PressStatus::unstable:
            return EquilibriumStatus::unstable;
        case PressStatus::inside_out:
            return EquilibriumStatus::inside_out;
        case PressStatus::lost:
            break;
    }
    return EquilibriumStatus::not_converged;
}

}  // namespace

LawPress::LawPress(const SpringMesh& mesh, LawModel law)
    : law_(std::move(law)), energy_(mesh, law_.incompressible), surface_(mesh) {}

std::unique_ptr<PressSolver> LawPress::take() const {
    {
        const std::lock_guard<std::mutex> lock(guard_);
        if (!idle_.empty()) {
            std::unique_ptr<PressSolver> solver = std::move(idle_.back());
            idle_.pop_back();
            return solver;
        }
    }
    return std::make_unique<PressSolver>(energy_, surface_);
}

Equilibrium LawPress::at(double arc_m, const Eigen::Vector2d& push_m) const {
    const ContactPatch patch = surface_.at(arc_m);
    std::unique_ptr<PressSolver> solver = take();
    try {
        PressState state = solver->press(law_.constants, {patch, law_.patch.at(patch)}, push_m);
        const std::lock_guard<std::mutex> lock(guard_);
        idle_.push_back(std::move(solver));
        return {std::move(state.displacement), state.contact_force_N, status_of(state.status)};
    } catch (const MismatchError&) {  // nothing to push there
        return {NodeField::Zero(energy_.node_count(), 2), Eigen::VectorXd::Zero(2), EquilibriumStatus::contact_fixed};
    }
}

}  // namespace tissue
