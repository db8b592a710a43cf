#pragma once

#include <vector>

#include "cases/history.h"
#include "io/dataset_table.h"

namespace tissue {

/// Rules of the group /histories of cases.h5: H histories, one after the other in K rows.
const DatasetTable& histories_table();

void write_histories(TableWriter& out, const std::vector<History>& histories, Eigen::Index dimension);

/// Throws FileError as TableReader, and where offsets, times, contacts or NaN rows are inconsistent.
std::vector<History> read_histories(TableReader& in);

}  // namespace tissue
