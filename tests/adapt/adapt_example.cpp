#include "adapt_example.h"

#include <algorithm>

#include "../haptic/haptic_example.h"
#include "mesh/outline.h"
#include "springs/indentation_solver.h"

namespace tissue {

std::vector<ForceMeasurement> pokes_of(const TissueModel& target, int count, unsigned long seed) {
    const Outline outline(target.mesh);
    const IndentationSolver solver(target);
    Draw draw(seed);
    std::vector<ForceMeasurement> pokes;
    while (static_cast<int>(pokes.size()) < count) {
        const double arc = draw(0.03, outline.length() - 0.03);
        const Eigen::Vector2d push = draw(0.003, 0.008) * outline.direction(arc, draw(-0.4, 0.4));
        const Equilibrium answer = solver.at(outline.position(arc), push);
        if (answer) pokes.push_back({outline.position(arc), push, answer.contact_force});
    }
    return pokes;
}

double worst_error(const TissueModel& model, const std::vector<ForceMeasurement>& pokes) {
    const IndentationSolver solver(model);
    double worst = 0;
    for (const ForceMeasurement& poke : pokes) worst = std::max(worst, (solver.at(poke.contact_m, poke.push_m).contact_force - poke.force_N).norm() / poke.force_N.norm());
    return worst;
}

TissueModel stiffer(TissueModel model, double log_stiffness) {
    model.energy_model->constants *= std::exp(log_stiffness);
    model.energy_model->contact_log_scale = Eigen::VectorXd::Constant(model.mesh.node_count(), log_stiffness);
    return model;
}

}  // namespace tissue
