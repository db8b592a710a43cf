#pragma once

#include <optional>
#include <string>

#include "adapt/adaptation.h"
#include "io/dataset_table.h"

namespace tissue {

/// Writes the adapted model as a model.h5. Group /adaptation has what further adaptation needs: the energy model before
/// the first measurement, the options, and Adaptation::State. Continuing from the file gives the same result as an
/// uninterrupted adaptation, bit for bit.
void write_adapted_model(const std::string& file, const Adaptation& adaptation, const Provenance& provenance);

/// Reads an adaptation from such a file. For a model.h5 without group /adaptation a new one with the options `fresh`.
/// Throws FileError as read_model, and for a group /adaptation whose parts do not fit together.
std::unique_ptr<Adaptation> read_adaptation(const std::string& file, const AdaptOptions& fresh);

/// Options of the adaptation in a file; absent without group /adaptation.
std::optional<AdaptOptions> adapted_options(const std::string& file);

/// Adapted stiffness at each node.
struct LearnedField {
    Eigen::VectorXd factor, sd;  ///< stiffness over the trained one; posterior standard deviation of its logarithm (N)
    int pokes;                   ///< number of learned measurements
};

/// Absent for unknowns other than `field`.
std::optional<LearnedField> learned_field(const Adaptation& adaptation);

/// The same of a file; absent without group /adaptation, and for unknowns other than `field`. Throws as
/// read_adaptation.
std::optional<LearnedField> learned_field(const std::string& file);

/// Datasets of group /adaptation: shape, values, unit and meaning.
const DatasetTable& adaptation_table();

}  // namespace tissue
