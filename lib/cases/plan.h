#pragma once

#include <map>
#include <optional>
#include <string>

#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// A study's input to make: a fragment that the Makefile includes, and for every stage a file with everything that the
/// stage depends on. Such a file is only written when its text changes. A change of [training] thus does not repeat FE
/// solves.
struct Plan {
    std::string fragment;                      ///< plan.mk; $(R) stands for the study's results folder
    std::map<std::string, std::string> parts;  ///< text of each file, by its name under $(R)/plan/
};

/// shape: the meshed shape of a study that has one. Without it the plan of such a study only has the rules that mesh
/// the shape (SHAPE, SHAPE_ARGUMENTS for gmsh) and then make plan.mk again.
/// Throws StudyError for a study that cannot be solved or trained, and for names that make cannot have.
Plan make_plan(const Study& study, const std::optional<Shape>& shape = {});

/// The file of the study's shape and gmsh's arguments for it, in the form that scripts/mesh takes. Throws StudyError as
/// make_plan.
std::string shape_words(const Study& study);

}  // namespace tissue
