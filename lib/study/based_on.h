#pragma once

#include <string>
#include <vector>

#include "study/toml.h"

namespace tissue {

/// Rule for a study that is based on another one: where the study gives `given`, the base's keys `dropped` are ignored,
/// because they would contradict it. A key that no rule drops is taken from the base unless the study gives it.
struct BaseRule {
    std::string given;                 ///< key of the study, with its value where the rule depends on it
    std::vector<std::string> dropped;  ///< keys and whole tables of the base; '*' stands for every name
    std::string why;
};

/// All rules, in the order in which they are applied. results/FORMATS.md has the same table
/// (tests/study/test_based_on.cpp).
std::vector<BaseRule> base_rules();

/// Parses the TOML file of a study or a material. Throws FileError where there is no file, StudyError where it is not
/// TOML.
toml::table parse_study_file(const std::string& file);

/// A study's tables, completed by those of the study that it is based on, by the rules above. A list is replaced as a
/// whole. Every key keeps the file and line that it comes from; a table that both have keeps the study's.
/// Throws as parse_study_file; StudyError where `based_on` is no text, or for a chain of more than 9 bases (a circle).
toml::table parse_with_base(const std::string& file);

/// Adds to `table` the keys of `base` that it does not have, also within tables that both have. Nodes are moved,
/// because a copy of a node loses its file and line.
void underlay(toml::table& table, toml::table&& base);

}  // namespace tissue
