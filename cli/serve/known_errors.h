#pragma once

#include <optional>
#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue::serve {

/// How far the learned model's contact force is off FE at one contact that FE have solved, in equilibrium without relaxation, as `tissuectl eval` has it.
struct KnownError {
    std::string role;                  ///< "trained", or of the study's draws
    Point contact_m, direction;        ///< at rest; unit vector (3)
    double depth_m = 0;
    std::optional<double> force = {};  ///< |r - r_fe| / |r_fe|; nothing: the model has no answer
    Point inward = {};                 ///< unit normal of the surface there, which the scene finds
};

struct KnownErrors {
    std::vector<KnownError> all;  ///< empty when nothing is known
    std::string warning;          ///< why an eval.json that is there is not used; else empty
};

/// Reads the eval.json that stands in the folder of a model.h5 in space. It belongs to the model when it has the model file's hash; training contacts are the model's load cases by
/// name, drawn ones must lie on its surface. Throws nothing: the model plays without.
KnownErrors read_known_errors(const std::string& model_file, const TissueModel& tissue);

}  // namespace tissue::serve
