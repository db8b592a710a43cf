#pragma once

#include <string>
#include <vector>

#include "cases/history.h"
#include "study/study.h"

namespace tissue {

/// Measured courses of the tool in time: a CSV with a header `history, time [s], contact_x [mm], ..., force_y [mN]` in any order, if you like with
/// `kind` and `role` (results/FORMATS.md). Rows of one history stand together; a contact keeps its place, and the tool holds it throughout.
///
/// The split is by contact, as measured_cases has it: the file's roles stand; else the study's seed draws among contacts 2 mm apart, of
/// which one at least stays to fit shares to, and one is held out. It is a split of histories alone: pushes train the law, which knows no
/// time, wherever they are. Times begin at 0.
///
/// Throws FileError with file, line and cause: columns and units as CsvColumns, a number that is none, times that do not ascend, a history
/// whose rows stand apart, that changes its contact, kind or role, that has fewer than 8 rows or no push, or does not begin at rest, a name
/// that cases.h5 cannot hold, one of role train within 2 mm of one of another; a contact off the outline or on the fixed edge; and with the
/// file alone where there are too few contacts, or none to fit to or to judge by.
std::vector<History> read_measured_histories(const Study& study, const std::string& file);

}  // namespace tissue
