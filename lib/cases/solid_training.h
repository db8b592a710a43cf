#pragma once

#include <optional>
#include <vector>

#include "mesh/free_surface.h"
#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// The study's training paths in space, in its order. For a block they are those of the file; for a shape their
/// contacts are found on the free surface of its springs.
/// Listed contacts are moved to its nearest point. Spread contacts: each facet is divided into 16 parts, whose centres
/// are the candidates if they keep the clearance from where the surface ends or turns. The first contact is the
/// candidate farthest from there. Each next one is the candidate farthest from those chosen (Gonzalez 1985, Theoretical
/// Computer Science 38: 293-306). Azimuths turn by the golden angle, 137.51 degrees, from contact to contact.
/// Throws StudyError with file, key and place: a contact farther from the surface than the spacing of its nodes, or too
/// near to where it ends or turns; a surface with fewer candidates than contacts.
std::vector<StudyPath> solid_training(const Study& study, const std::optional<Shape>& shape);

/// The free surface of the spring mesh of a study in space.
FreeSurface study_surface(const Study& study, const std::optional<Shape>& shape);

}  // namespace tissue
