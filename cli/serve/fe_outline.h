#pragma once

#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue::serve {

/// FE surface at one load case.
struct FeOutline {
    double depth_m;
    NodeField displacement_m;  ///< of the outline's nodes in its order; in space of the nodes Scene::shown() (B x D)
};

/// FE displacements of all load cases of a model.
struct FeCases {
    /// of every node, per load case (C) of (N x D); empty without FE displacements
    std::vector<NodeField> displacement_m;
    std::string warning;                    ///< why an existing cases.h5 is not used; else empty
};

/// Reads the cases.h5 in the folder of model_file. The result is empty without that file, and for measured cases, which
/// have no displacements. The file belongs to the model if study, nodes and every load case agree: name, contact,
/// direction, magnitude and, if the model has it, the FE force. Does not throw: the model runs without it.
FeCases read_fe_cases(const std::string& model_file, const TissueModel& tissue);

}  // namespace tissue::serve
