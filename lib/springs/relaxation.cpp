#include "springs/relaxation.h"

#include <cmath>

#include "springs/tissue_model.h"

namespace tissue {

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
