#pragma once

#include <optional>
#include <vector>

#include "cases/sweep.h"

namespace tissue {

/// All FE solves of a solid: the training paths, the drawn ones, those of the map, and part of role held_out again on
/// the finer mesh.
/// Drawn contacts on a block are uniform over the part of its top whose distance from the nearest wall is in the range
/// of their role. On a shape they are uniform by area over the part of the free surface whose distance from where it
/// ends or turns is in that range. Directions are uniform in solid angle between two tilts, on a shape from its smooth
/// normal. All drawn paths are 2 mm or 5 degrees from every training path.
/// Throws MismatchError when a draw finds no such path, StudyError as solid_training.
std::vector<PlannedPath> solid_paths(const Study& study, const std::optional<Shape>& shape = {});

}  // namespace tissue
