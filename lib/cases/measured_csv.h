#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace tissue {

/// One reading: a contact at rest, how far it was pushed, and the indenter's force on the tissue.
struct MeasuredRow {
    int line;                      ///< in its file
    Eigen::Vector2d contact_m, displacement_m, force_N;
    std::string push;              ///< rows of one push, measured again and again, say the same; may be empty
    std::string role;              ///< train, validation or held_out; empty where the split is left to a seed
};

struct MeasuredTable {
    std::string file;
    std::string origin;            ///< the comments at its head, without '#'
    std::vector<MeasuredRow> rows;
};

/// Reads measured contacts: comments ('#'), a header `contact_x [mm], ..., force_y [mN]` in any order with a unit a
/// column, then rows (results/FORMATS.md).
/// Throws FileError with file, line, column and cause: a column that is missing, unknown or twice, a unit that is absent
/// or not one of its kind, a field that is no finite number, a displacement or a force of zero, a row that stands twice.
MeasuredTable read_measured_csv(const std::string& file);

/// "2.5 mm", from a metre on "2.5 m".
std::string length_text(double length_m);

}  // namespace tissue
