#include "springs/law_press.h"

#include "error.h"
#include "springs/contact_errors.h"
#include "springs/law_at_radius.h"
#include "springs/law_kernel.h"

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
    : law_(std::move(law)), energy_(mesh, law_.incompressible), mesh_(mesh), kernel_(make_contact_kernel(mesh, law_)) {}

const LawPress& LawPress::of(double radius_m) const {
    if (radius_m == 0 || radius_m == law_.disc_radius_m) return *this;
    const std::lock_guard<std::mutex> lock(guard_);
    std::unique_ptr<LawPress>& other = others_[radius_m];
    if (!other) other = std::make_unique<LawPress>(mesh_, law_at_radius(law_, radius_m));
    return *other;
}

std::unique_ptr<PressSolver> LawPress::take() const {
    {
        const std::lock_guard<std::mutex> lock(guard_);
        if (!idle_.empty()) {
            std::unique_ptr<PressSolver> solver = std::move(idle_.back());
            idle_.pop_back();
            return solver;
        }
    }
    return std::make_unique<PressSolver>(energy_, *kernel_);
}

Equilibrium LawPress::at(const Point& contact_m, const Point& push_m) const {
    std::unique_ptr<PressSolver> solver = take();
    Equilibrium answer{NodeField::Zero(energy_.node_count(), energy_.dimension()), Eigen::VectorXd::Zero(energy_.dimension()), EquilibriumStatus::contact_fixed};
    try {
        PressState state = solver->press(law_.constants, ContactSpring(kernel_->rows_at(contact_m), law_.patch), push_m);
        answer = {std::move(state.displacement), state.contact_force_N, status_of(state.status)};
    } catch (const FixedContactError&) {
        answer.status = EquilibriumStatus::contact_fixed;
    } catch (const NoContactError&) {
        answer.status = EquilibriumStatus::no_contact;
    }
    const std::lock_guard<std::mutex> lock(guard_);
    idle_.push_back(std::move(solver));
    return answer;
}

NodeField LawPress::seen(const Point& contact_m, const Point& push_m, NodeField displacement_m) const {
    const SkinLaw skin = law_.skin();
    for (const SkinNode& at : kernel_->skin_at(contact_m))
        displacement_m.row(at.node) = at.shown(displacement_m.row(at.node).transpose(), skin, push_m).transpose();
    return displacement_m;
}

}  // namespace tissue
