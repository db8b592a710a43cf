#include "springs/indentation_solver.h"

#include <fmt/format.h>

#include <algorithm>

#include "error.h"
#include "springs/contact_errors.h"
#include "springs/energy_model_at_radius.h"
#include "springs/energy_model_kernel.h"

namespace tissue {

EquilibriumStatus status_of(SolverStatus status) {
    switch (status) {
        case SolverStatus::converged:
            return EquilibriumStatus::balanced;
        case SolverStatus::unstable:
            return EquilibriumStatus::unstable;
        case SolverStatus::inverted:
            return EquilibriumStatus::inverted;
        case SolverStatus::no_equilibrium:
            break;
    }
    return EquilibriumStatus::not_converged;
}

IndentationSolver::IndentationSolver(const SpringMesh& mesh, EnergyModel energy_model)
    : law_(std::move(energy_model)), energy_(mesh, law_), mesh_(mesh), kernel_(make_contact_kernel(mesh, law_)) {}

const IndentationSolver& IndentationSolver::of(double radius_m) const {
    if (radius_m == 0 || radius_m == law_.disc_radius_m) return *this;
    const std::lock_guard<std::mutex> lock(guard_);
    std::unique_ptr<IndentationSolver>& other = others_[radius_m];
    if (!other) other = std::make_unique<IndentationSolver>(mesh_, energy_model_at_radius(law_, radius_m));
    return *other;
}

std::unique_ptr<EquilibriumSolver> IndentationSolver::take() const {
    {
        const std::lock_guard<std::mutex> lock(guard_);
        if (!idle_.empty()) {
            std::unique_ptr<EquilibriumSolver> solver = std::move(idle_.back());
            idle_.pop_back();
            return solver;
        }
    }
    return std::make_unique<EquilibriumSolver>(energy_, *kernel_);
}

Equilibrium IndentationSolver::at(const Point& contact_m, const Point& push_m) const {
    ToolsEquilibrium rest = at(std::vector<ToolPush>{{contact_m, push_m}});
    return {std::move(rest.displacement), std::move(rest.contact_force.front()), rest.status};
}

void IndentationSolver::refuse_overlap(const std::vector<ToolPush>& tools) const {
    const double least_m = 2 * law_.disc_radius_m;
    for (std::size_t i = 0; i < tools.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            if (!(least_m > 0)) throw MismatchError("several tools at once need an energy model in space");
            const Point apart_m = tools[i].contact_m - tools[j].contact_m;
            const double rest_m = apart_m.norm(), pushed_m = (apart_m + tools[i].push_m - tools[j].push_m).norm();
            const double touch_m = least_m * (1 - 1e-9);
            if (std::min(rest_m, pushed_m) < touch_m)
                throw OverlappingToolsError(fmt::format("two discs are {:.3g} mm apart{}, nearer than two radii of {:g} mm", 1e3 * (rest_m < touch_m ? rest_m : pushed_m),
                                                        rest_m < touch_m ? "" : " under the indentation", 1e3 * law_.disc_radius_m));
        }
}

ToolsEquilibrium IndentationSolver::at(const std::vector<ToolPush>& tools) const {
    refuse_overlap(tools);
    std::unique_ptr<EquilibriumSolver> solver = take();
    const int D = energy_.dimension();
    ToolsEquilibrium answer{NodeField::Zero(energy_.node_count(), D), std::vector<Eigen::VectorXd>(tools.size(), Eigen::VectorXd::Zero(D)), EquilibriumStatus::contact_fixed};
    try {
        std::vector<DisplacedTool> pressed;
        for (const ToolPush& tool : tools) pressed.push_back({ContactSpring(kernel_->rows_at(tool.contact_m), law_.patch), tool.push_m});
        EquilibriumState state = solver->indent(law_.constants, std::move(pressed));
        answer = {std::move(state.displacement), {state.contact_force_N}, status_of(state.status)};
        for (const EquilibriumState::OtherTool& other : state.others) answer.contact_force.emplace_back(other.contact_force_N);
    } catch (const FixedContactError&) {
        answer.status = EquilibriumStatus::contact_fixed;
    } catch (const NoContactError&) {
        answer.status = EquilibriumStatus::no_contact;
    }
    const std::lock_guard<std::mutex> lock(guard_);
    idle_.push_back(std::move(solver));
    return answer;
}

NodeField IndentationSolver::displayed(const Point& contact_m, const Point& push_m, NodeField displacement_m) const {
    const SkinParameters skin = law_.skin();
    for (const SkinNode& at : kernel_->skin_at(contact_m))
        displacement_m.row(at.node) = at.shown(displacement_m.row(at.node).transpose(), skin, push_m).transpose();
    return displacement_m;
}

}  // namespace tissue
