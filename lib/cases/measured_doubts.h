#pragma once

#include <string>
#include <vector>

#include "cases/history.h"
#include "cases/measured_csv.h"
#include "study/study.h"

namespace tissue {

/// What in a table of measurements is likely a mistake, though each row by itself is a measurement: a line each, with the lines of the file. Empty
/// where there is nothing to doubt. Nothing is left out for it.
///   a unit         the median of force over E2 times displacement is not within a factor of 100 of 1, which tissue of the study's modulus answers
///   contradiction  two rows at one contact, within 0.2 mm and 5 % of the displacement, whose forces differ by more than 30 %
///   drift          rows of one push (column `push`), in the file's order, go away from their push's mean by 5 standard errors of a straight line, and
///                  by 2 % of the force or more from the first row to the last
std::vector<std::string> measured_doubts(const Study& study, const MeasuredTable& table);
/// The same of measured histories, of their unit alone.
std::vector<std::string> measured_doubts(const Study& study, const std::vector<History>& histories);

}  // namespace tissue
