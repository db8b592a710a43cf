#pragma once

#include <map>
#include <optional>
#include <string>

#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// What make needs to know of a study: a fragment that it includes, and for every stage a file that says all the
/// stage depends on. Such a file is only written when its text changes, so editing training does not solve FE again.
struct Plan {
    std::string fragment;                      ///< plan.mk; $(R) stands for the study's results folder
    std::map<std::string, std::string> parts;  ///< file name under $(R)/plan/ -> text
};

/// shape: of a study that has one; without it the plan says only where the shape comes from (SHAPE, SHAPE_ARGUMENTS
/// for gmsh) and that there is more to plan once it is meshed.
Plan make_plan(const Study& study, const std::optional<Shape>& shape = {});

/// The file of the study's shape and gmsh's arguments for it, as scripts/mesh takes them. Throws StudyError as make_plan.
std::string shape_words(const Study& study);

}  // namespace tissue
