#pragma once

#include <array>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// One FE solve of a study: which push, how deep, and what it is for.
struct PlannedPath {
    StudyPath push;
    std::string role;    ///< train, validation, held_out, held_out_full, map, check (one of them again, on the finer mesh)
    double depth_m;
    int records;         ///< after the one at rest
    int refine;          ///< of the mesh it is solved on
    std::array<double, 2> sizes_m = {};  ///< of a solid: of that mesh's elements, near the contact and far from it
};

/// Every FE solve a study needs, in a fixed order, all drawn before any of them runs. Of training contacts that mirror
/// each other only one is solved (mirrored() makes the other). Drawn contacts keep 2 mm or 5 degrees from every
/// training contact. A shape, for a study that has one, need not mirror itself: all its contacts are solved.
/// Of a solid: cases/solid_sweep.h. Every name stands once. Throws MismatchError when a draw finds no such contact, and when a listed path is named as
/// another's check.
std::vector<PlannedPath> planned_paths(const Study& study, const std::optional<Shape>& shape = {});

/// The cases with only those training paths and magnitudes that a variant keeps; drawn contacts and histories stay.
Cases thinned(const Study& study, const Cases& cases, const Study::Variant& variant);

}  // namespace tissue
