#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "io/dataset_table.h"

namespace tissue {

/// Alters one dataset of the file at a time, as its rule suggests: missing, of another type or shape, and with values
/// that are not finite, out of range or repeated. Calls read with each altered copy. Fails the test if a copy that
/// violates the rule is read, or if a FileError is not one line that begins with the copy's name and `place`. Returns
/// the number of copies that were refused. wanted: which datasets are altered; without it all that the table has a rule
/// for.
int refused_mutations(const std::string& file, const DatasetTable& table, const std::function<void(const std::string&)>& read,
                      const std::string& place = "/", const std::function<bool(const std::string&)>& wanted = {});

/// Datasets of the file that the table has a rule for, with the rules. A rule with "NAME" covers a dataset of every
/// group.
std::vector<std::pair<std::string, const DatasetRule*>> datasets_of(const std::string& file, const DatasetTable& table);

}  // namespace tissue
