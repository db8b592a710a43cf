#pragma once

#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue::serve {

/// FE's surface at one load case.
struct FeOutline {
    double depth_m;
    NodeField displacement_m;  ///< of the outline's nodes in its order, in space of Scene::shown() (B x D)
};

/// What FE say inside the tissue at each load case of a model.
struct FeCases {
    std::vector<NodeField> displacement_m;  ///< of every node (C) of (N x D); empty when nothing is known of it
    std::string warning;                    ///< why a cases.h5 that is there is not used; else empty
};

/// Reads the cases.h5 that stands in the folder of model.h5. Without one, and of measured ones, which say nothing of
/// the inside, nothing is known. It belongs to the model when study, nodes and every load case are the same: name, contact,
/// direction, magnitude and, where the model carries it, FE's force. Throws nothing: the model plays without.
FeCases read_fe_cases(const std::string& model_file, const TissueModel& tissue);

}  // namespace tissue::serve
