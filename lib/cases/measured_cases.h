#pragma once

#include "cases/load_path.h"
#include "cases/measured_csv.h"
#include "study/study.h"

namespace tissue {

/// Measured contacts as cases. Rows of one push are averaged into one load case to train on, and so are pushes as deep within 0.2 mm
/// and 3 degrees, from the first to the last of them; what is held out stays as it was measured, a row a path.
///
/// The split is by contact, never by row: contacts less than 2 mm apart along the surface go together, so that every
/// held-out contact keeps 2 mm from every trained one. The table's own roles stand; else the study's seed draws, and
/// the outermost contacts and those at corners are trained on, since nothing reaches beyond or round them.
///
/// Noise is the scatter of repeats about their push's mean. A row more than 5 standard deviations from its repeats is
/// named as an outlier, and kept.
///
/// Throws FileError with file, line and cause: a contact off the outline or on the fixed edge, a push out of the tissue,
/// a force against it, rows of one push that differ by more than repeats do, a held-out contact near a trained one; and
/// with the file alone when there are too few contacts.
Cases measured_cases(const Study& study, const MeasuredTable& table);

}  // namespace tissue
