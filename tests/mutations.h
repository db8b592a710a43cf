#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/dataset_table.h"

namespace tissue {

/// One wrong thing done to one dataset of a file.
struct Mutation {
    std::string name;                                ///< "a row more"
    std::function<void(const std::string&)> apply;   ///< to this file
    bool must_be_refused = true;                     ///< false: what comes of it may be another file that is well
};

/// Every way to do wrong to a dataset as it stands in the file, by what its rule says of it: missing, of another type,
/// another shape, values that are none, out of range or repeated.
std::vector<Mutation> mutations(const std::string& file, const std::string& dataset, const DatasetTable& table);

/// The table's datasets as they stand in the file: "NAME" for every group there is.
std::vector<std::pair<std::string, const DatasetRule*>> datasets_of(const std::string& file, const DatasetTable& table);

}  // namespace tissue
