#pragma once

#include <string>
#include <vector>

#include "study/toml.h"

namespace tissue {

/// What a study leaves out of the study that it is based on: where the study gives `given`, the base's keys `dropped` do not count,
/// because they would contradict it. What no rule names is the base's unless the study gives it.
struct BaseRule {
    std::string given;                 ///< key of the study, and its value where that matters
    std::vector<std::string> dropped;  ///< keys and whole tables of the base; '*' stands for every name
    std::string why;
};

/// Every rule, in the order in which they are applied. results/FORMATS.md has the same table (tests/study/test_based_on.cpp).
std::vector<BaseRule> base_rules();

/// One TOML file of a study or a material. Throws FileError where there is none, StudyError for what is not TOML.
toml::table parse_study_file(const std::string& file);

/// A study's tables over those of the study that it is based on, by the rules above; lists are replaced whole. Every key knows the
/// file and line where it stands, and a table that both have is the study's.
/// Throws as parse_study_file; StudyError for a circle.
toml::table parse_with_base(const std::string& file);

/// Adds to `table` what it does not have of `base`. Nodes are moved: a copy forgets its file and line.
void underlay(toml::table& table, toml::table&& base);

}  // namespace tissue
