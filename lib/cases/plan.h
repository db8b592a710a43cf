#pragma once

#include <map>
#include <string>

#include "study/study.h"

namespace tissue {

/// What make needs to know of a study: a fragment that it includes, and for every stage a file that says all the
/// stage depends on. Such a file is only written when its text changes, so editing training does not solve FE again.
struct Plan {
    std::string fragment;                      ///< plan.mk; $(R) stands for the study's results folder
    std::map<std::string, std::string> parts;  ///< file name under $(R)/plan/ -> text
};

Plan make_plan(const Study& study);

}  // namespace tissue
