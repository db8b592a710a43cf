#pragma once

#include "io/dataset_table.h"

namespace tissue {

/// What each dataset of TrainingBooks in model.h5 is and must be: writer, reader and tests walk it.
const DatasetTable& books_table();

/// And of those of a law.
const DatasetTable& law_books_table();

}  // namespace tissue
