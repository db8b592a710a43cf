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

/// shape: of a study that has one. Throws MismatchError when it is missing.
Plan make_plan(const Study& study, const std::optional<Shape>& shape = {});

/// What make needs to know before there is a mesh, and so before there is a plan: where the shape comes from.
/// Defines SHAPE (empty for the block) and SHAPE_ARGUMENTS for gmsh; the mesh depends on the file plan/shape.
Plan make_shape_plan(const Study& study);

}  // namespace tissue
