#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/dataset_table.h"

namespace tissue {

/// One alteration of one dataset of a file.
struct Mutation {
    std::string name;                                ///< "one row added"
    std::function<void(const std::string&)> apply;   ///< alters the file with this name
    bool must_be_refused = true;                     ///< false: the altered file may be valid
};

/// All alterations of a dataset of the file that follow from its rule: missing, of another type or shape, and with
/// values that are not finite, out of range or repeated.
std::vector<Mutation> mutations(const std::string& file, const std::string& dataset, const DatasetTable& table);

/// Datasets of the file that the table has a rule for, with the rules. A rule with "NAME" covers a dataset of every
/// group.
std::vector<std::pair<std::string, const DatasetRule*>> datasets_of(const std::string& file, const DatasetTable& table);

}  // namespace tissue
