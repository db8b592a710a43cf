#pragma once

#include "io/dataset_table.h"

namespace tissue {

/// Datasets of TrainingDiagnostics for spring sets in model.h5: shape, values, unit, meaning. For writer, reader and tests.
const DatasetTable& books_table();

/// The same for TrainingDiagnostics::law, the training of an energy model.
const DatasetTable& energy_model_diagnostics_table();

}  // namespace tissue
