#pragma once

#include <optional>
#include <vector>

#include "mesh/free_surface.h"
#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// The study's training pushes in space, in its order: a block's own, and those of a shape's contacts, whose places are found
/// on the free surface of its springs. Listed ones move to its nearest point. Spread ones: each facet is divided into 16
/// and the middles of these may be chosen that keep their distance from where the surface ends or turns; the first is the
/// one farthest from there, each next the one farthest from those chosen (Gonzalez 1985, Theoretical Computer Science 38:
/// 293-306); azimuths turn by the golden angle, 137.51 degrees, from contact to contact.
/// Throws StudyError with file, key and place: a contact off the surface by more than its nodes' spacing, or too near to where
/// it ends or turns; a surface with no room for so many.
std::vector<StudyPath> solid_training(const Study& study, const std::optional<Shape>& shape);

/// The free surface of the springs of a study whose tissue is a solid shape.
FreeSurface study_surface(const Study& study, const std::optional<Shape>& shape);

}  // namespace tissue
