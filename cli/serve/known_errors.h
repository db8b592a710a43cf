#pragma once

#include <optional>
#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue::serve {

/// Relative error of the trained model's contact force at one contact with an FE reference, in equilibrium without
/// relaxation, as `tissuectl eval` computes it.
struct ReferenceError {
    std::string role;                  ///< "trained", or a role of the study's draws
    Point contact_m, direction;        ///< at rest; unit vector (3)
    double depth_m = 0;
    std::optional<double> force = {};  ///< |r - r_fe| / |r_fe|; nullopt: the model has no answer
    Point inward = {};                 ///< unit normal of the surface at the contact; set by the scene
};

struct KnownErrors {
    std::vector<ReferenceError> all;  ///< empty without an eval.json
    std::string warning;          ///< why an existing eval.json is not used; else empty
};

/// Reads the eval.json in the folder of a model.h5 in space. It belongs to the model if it contains the hash of the
/// model file. Training contacts are found among the model's load cases by name; drawn contacts must lie on its
/// surface. Does not throw: the model runs without it.
KnownErrors read_reference_errors(const std::string& model_file, const TissueModel& tissue);

}  // namespace tissue::serve
