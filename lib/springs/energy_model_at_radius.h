#pragma once

#include "springs/tissue_model.h"
#include "springs/tool_choice.h"

namespace tissue {

/// Energy model in space for a disc of another radius [m], as a model of that disc only, so that the tick treats it as
/// any other. Its contact parameters change with the radius as their start does, and by the trained terms `size`
/// (resized() in springs/energy_model_terms.h). Its lattice correction is that of the radius. radius_m = 0: the model unchanged. Throws
/// MismatchError for a radius outside the range of the training discs; the message gives that range.
EnergyModel energy_model_at_radius(const EnergyModel& energy_model, double radius_m);
/// The same for any radius > 0 [m]. Outside the range of the training discs the parameters follow their analytical
/// start (springs/patch_sizes.h). Throws MismatchError for a model trained under one disc only.
EnergyModel energy_model_of_contact(const EnergyModel& energy_model, double radius_m);
/// The model for a ball of radius ball_m [m] while its contact has the radius contact_m > 0 [m].
EnergyModel energy_model_of_ball(const EnergyModel& energy_model, double ball_m, double contact_m);

/// The model with the energy model of that tool, for a session; no file contains it. Its load cases remain, also those
/// of other discs (TissueModel::is_own_case). For a ball it is the energy model of the contact when half of the ball is
/// in the tissue, from which HapticModel makes the ball. Throws MismatchError for a model without a disc. For a ball it
/// also throws for a model trained under one disc only, one that relaxes, and one whose discs do not include that
/// contact.
TissueModel with_tool(TissueModel model, const ToolChoice& tool);

}  // namespace tissue
