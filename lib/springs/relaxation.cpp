#include "springs/relaxation.h"

#include <cmath>

#include "springs/tissue_model.h"

namespace tissue {

NodeField relaxed(const Eigen::VectorXd& time_s, const NodeField& force_N, const Eigen::VectorXd& tau_s, const Eigen::VectorXd& share) {
    NodeField out = (1 - share.sum()) * force_N;
    for (Eigen::Index k = 0; k < tau_s.size(); ++k) {
        Eigen::RowVectorXd part = Eigen::RowVectorXd::Zero(force_N.cols());
        for (Eigen::Index n = 1; n < force_N.rows(); ++n) {
            const double x = (time_s[n] - time_s[n - 1]) / tau_s[k];
            part = std::exp(-x) * part - std::expm1(-x) / x * (force_N.row(n) - force_N.row(n - 1));
            out.row(n) += share[k] * part;
        }
    }
    return out;
}

EnergyModel instantaneous(const EnergyModel& energy_model) {
    EnergyModel now = energy_model;
    now.relaxation = {};
    return now;
}

EnergyModel long_term(const EnergyModel& energy_model) {
    EnergyModel later = instantaneous(energy_model);
    if (energy_model.relaxation.empty()) return later;
    later.constants.array() *= 1 - energy_model.relaxation.share.rowwise().sum().array();
    const double left = std::log(1 - energy_model.relaxation.contact_share.sum());
    // hardening and saturation are per energy: they scale with the inverse
    for (Eigen::Index row = 0; row < later.patch.log_N_m.rows(); ++row)
        later.patch.log_N_m(row, 0) += row == ContactParameters::hardening_row || row == ContactParameters::saturation_row ? -left : left;
    return later;
}

}  // namespace tissue
