#include "adapt_example.h"

#include <algorithm>

#include "../haptic/haptic_example.h"
#include "mesh/outline.h"
#include "springs/law_press.h"

namespace tissue {

std::vector<Poke> pokes_of(const TissueModel& truth, int count, unsigned long seed) {
    const Outline outline(truth.mesh);
    const LawPress press(truth);
    Draw draw(seed);
    std::vector<Poke> pokes;
    while (static_cast<int>(pokes.size()) < count) {
        const double arc = draw(0.03, outline.length() - 0.03);
        const Eigen::Vector2d push = draw(0.003, 0.008) * outline.direction(arc, draw(-0.4, 0.4));
        const Equilibrium answer = press.at(outline.position(arc), push);
        if (answer) pokes.push_back({outline.position(arc), push, answer.contact_force});
    }
    return pokes;
}

double worst_error(const TissueModel& model, const std::vector<Poke>& pokes) {
    const LawPress press(model);
    double worst = 0;
    for (const Poke& poke : pokes) worst = std::max(worst, (press.at(poke.contact_m, poke.push_m).contact_force - poke.force_N).norm() / poke.force_N.norm());
    return worst;
}

TissueModel stiffer(TissueModel model, double log_stiffness) {
    model.energy_law->constants *= std::exp(log_stiffness);
    model.energy_law->contact_log_scale = Eigen::VectorXd::Constant(model.mesh.node_count(), log_stiffness);
    return model;
}

}  // namespace tissue
