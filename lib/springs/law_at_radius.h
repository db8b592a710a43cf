#pragma once

#include "springs/tissue_model.h"

namespace tissue {

/// The law of a model in space under a disc of another radius, as a law of that disc alone, which a tick takes like any other. Its contact's rows grow with the radius as those of a half space do
/// (energy_law.h, resized) and by what terms `size` have learned; its correction is of that radius. 0: the law as it is.
/// Throws MismatchError, which names the radii that the law knows, for a disc smaller or larger than those it was trained under.
LawModel law_at_radius(const LawModel& law, double radius_m);

/// A model with that law; its load cases stay, those of other discs too (is_own_case). For playing: it is in no file. Throws MismatchError for a model that has no disc.
TissueModel with_tool(TissueModel model, double radius_m);

}  // namespace tissue
