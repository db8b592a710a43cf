#pragma once

#include <string>
#include <vector>

#include "cases/history.h"
#include "study/study.h"

namespace tissue {

/// Reads measured displacement histories of the tool: a CSV with a header `history, time [s], contact_x [mm], ...,
/// force_y [mN]` with columns in any order, optionally `kind` and `role` (results/FORMATS.md). The rows of one history
/// are contiguous; its contact stays the same, and the tool stays at it throughout. Times are shifted to begin at 0.
///
/// The split is by contact, as in measured_cases. The file's roles are used where it has them. Else they are drawn by
/// the study's seed among groups of contacts 2 mm apart; one group at least is for training, to fit relative moduli to,
/// and one for the test set. Only histories are split. The indentations of `data.file` contain no time and train the
/// energy model wherever their contacts lie.
///
/// Throws FileError with file, line and cause:
///   columns and units as CsvColumns; a field that is no number; times that do not ascend
///   a name that cases.h5 cannot have; rows of one history that are not contiguous
///   a contact, kind or role that changes within a history
///   a contact off the outline, or within 2 mm of the fixed edge
///   fewer than 8 rows; no displacement or no force; a first displacement above 5 % of the largest
///   a displacement out of the tissue or longer than it; a force against the largest displacement
///   a training history within 2 mm of one of another role
/// and with the file alone where there are too few contacts, or no history for training or for the test set.
std::vector<History> read_measured_histories(const Study& study, const std::string& file);

}  // namespace tissue
