#pragma once

#include <string>
#include <vector>

#include "cases/history.h"
#include "cases/measured_csv.h"
#include "study/study.h"

namespace tissue {

/// Warnings for likely mistakes in a table of measurements whose rows are valid one by one: a text for each, with the
/// lines of the file. Empty where there are none. No row is left out because of a warning.
///   a unit         The median of force / (E2 displacement) is not within a factor of 100 of 1. Tissue of the study's
///                  modulus has some 0.3 to 3.
///   contradiction  Two rows at one contact (within 0.2 mm), with the same displacement (within 5 %), have forces that
///                  differ by more than 30 % of the larger one.
///   drift          Each force is divided by the mean of its indentation (column `push`). One straight line is fitted
///                  to all these ratios in the order of the rows. Its slope is 5 standard errors or more, and it
///                  changes by 2 % or more from the first row to the last.
std::vector<std::string> measurement_warnings(const Study& study, const MeasuredTable& table);
/// The same for measured histories; only the unit is checked.
std::vector<std::string> measurement_warnings(const Study& study, const std::vector<History>& histories);

}  // namespace tissue
