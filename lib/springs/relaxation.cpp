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

LawModel instantaneous(const LawModel& law) {
    LawModel now = law;
    now.relaxation = {};
    return now;
}

LawModel long_term(const LawModel& law) {
    LawModel later = instantaneous(law);
    if (law.relaxation.empty()) return later;
    later.constants.array() *= 1 - law.relaxation.share.rowwise().sum().array();
    const double left = std::log(1 - law.relaxation.contact_share.sum());
    for (Eigen::Index row = 0; row < later.patch.log_N_m.rows(); ++row)  // hardening and saturation are by energy
        later.patch.log_N_m(row, 0) += row == PatchLaw::hardening_row || row == PatchLaw::saturation_row ? -left : left;
    return later;
}

}  // namespace tissue
