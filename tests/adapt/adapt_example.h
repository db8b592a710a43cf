#pragma once

#include <vector>

#include "adapt/adaptation.h"

namespace tissue {

/// Measurements on a model without noise: normal and tilted indentations of 3 to 8 mm at random places on the block of
/// energy_model_example.
std::vector<ForceMeasurement> pokes_of(const TissueModel& target, int count, unsigned long seed = 1);

/// Largest |model - measured| / |measured| force of the measurements.
double worst_error(const TissueModel& model, const std::vector<ForceMeasurement>& pokes);

/// The energy model with all its stiffnesses, contacts included, multiplied by exp(log_stiffness).
TissueModel stiffer(TissueModel model, double log_stiffness);

}  // namespace tissue
