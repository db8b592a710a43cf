#pragma once

#include "springs/tissue_model.h"
#include "springs/tool_choice.h"

namespace tissue {

/// The law of a model in space under a disc of another radius, as a law of that disc alone, which a tick takes like any other. Its contact's rows change with the radius as their start does
/// (energy_law.h, resized) and by what terms `size` have learned; its correction is of that radius. 0: the law as it is.
/// Throws MismatchError, which names the radii that the law knows, for a disc smaller or larger than those it was trained under.
LawModel law_at_radius(const LawModel& law, double radius_m);
/// The same of any radius > 0, beyond those discs as rows start (springs/patch_sizes.h). Throws MismatchError for a law that knows one disc alone.
LawModel law_of_contact(const LawModel& law, double radius_m);
/// That of a ball of radius ball_m while its contact has the radius contact_m > 0.
LawModel law_of_ball(const LawModel& law, double ball_m, double contact_m);

/// A model with the law of that tool; its load cases stay, those of other discs too (is_own_case). For playing: it is in no file. A ball's law is that of its contact where half of it is in
/// (HapticModel makes the ball of it). Throws MismatchError for a model that has no disc, and for a ball where the model knows one disc alone, does not know that contact, or relaxes.
TissueModel with_tool(TissueModel model, const ToolChoice& tool);

}  // namespace tissue
