#pragma once

#include "cases/load_path.h"
#include "cases/measured_csv.h"
#include "study/study.h"

namespace tissue {

/// Cases from measured contacts. Rows of one indentation (column `push`) are averaged into one load case for training.
/// So are indentations of the same depth (to 0.1 um) whose contacts all lie within 0.2 mm and whose directions all lie
/// within 3 degrees. In validation and test set every row is a path of its own.
///
/// The split is by contact, never by row. Contacts less than 2 mm apart along the surface get the same role. So every
/// contact of the test set is at least 2 mm from every training contact. The table's roles are used where it has them;
/// else roles are drawn by the study's seed. The outermost contacts and those at corners are then training contacts,
/// because the model cannot extrapolate beyond or round them.
///
/// Noise is the scatter of repeats about the mean of their indentation. A row more than 5 standard deviations from its
/// repeats is listed as an outlier, and kept.
///
/// Throws FileError with file, line and cause:
///   a contact off the outline, or within 2 mm of the fixed edge
///   a displacement out of the tissue or longer than it; a force against the displacement
///   rows of one indentation that differ by more than repeats do
///   a contact of the test or validation set within 2 mm of a training contact
/// and with the file alone when there are fewer than four places to train on, or no contact for the test set.
Cases measured_cases(const Study& study, const MeasuredTable& table);

}  // namespace tissue
