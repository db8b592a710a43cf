#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace tissue {

/// One measurement: contact at rest, displacement of the contact, and force of the indenter on the tissue.
struct MeasuredRow {
    int line;                      ///< in its file
    Eigen::Vector2d contact_m, displacement_m, force_N;
    std::string push;              ///< name of the indentation, the same in all its repeats; may be empty
    std::string role;              ///< train, validation or held_out; empty where the split is drawn by a seed
};

struct MeasuredTable {
    std::string file;
    std::string origin;            ///< the comments at its head, without '#'
    std::vector<MeasuredRow> rows;
};

/// Reads measured contacts: comments ('#'), a header `contact_x [mm], ..., force_y [mN]` with columns in any order and
/// a unit for each number, then rows (results/FORMATS.md).
/// Throws FileError with file, line, column and cause: a column that is missing, unknown or double, a unit that is
/// absent or of another quantity, a field that is no finite number, a displacement or a force of zero, a row that
/// occurs twice.
MeasuredTable read_measured_csv(const std::string& file);

/// A length as text: "2.5 mm"; from 1 m on "2.5 m".
std::string length_text(double length_m);

}  // namespace tissue
