#pragma once

#include <optional>
#include <string>

#include "adapt/adaptation.h"
#include "io/dataset_table.h"

namespace tissue {

/// A model.h5 that plays as it has learned to, and in group /adaptation what it takes to learn on: the law as it was trained, how it
/// learns, and State. To go on from it, or to have gone all the way at once, is the same to the last bit.
void write_adapted_model(const std::string& file, const Adaptation& adaptation, const Provenance& provenance);

/// Of a file so written; of a model.h5 that has learned nothing yet, with `fresh`. Throws FileError as read_model, and for a group
/// /adaptation whose parts do not fit together.
std::unique_ptr<Adaptation> read_adaptation(const std::string& file, const AdaptOptions& fresh);

/// The options it was begun with; nothing where it has learned nothing.
std::optional<AdaptOptions> adapted_options(const std::string& file);

/// What such a file has learned of each node: how many times as stiff it is as trained, and the standard deviation of that number's logarithm (N).
struct LearnedField {
    Eigen::VectorXd factor, sd;
    int pokes;
};

/// Nothing where it learns other unknowns than `field`.
std::optional<LearnedField> learned_field(const Adaptation& adaptation);

/// Nothing where it has learned nothing, or on other unknowns than `field`. Throws as read_adaptation.
std::optional<LearnedField> learned_field(const std::string& file);

/// What every dataset of it is and must be.
const DatasetTable& adaptation_table();

}  // namespace tissue
