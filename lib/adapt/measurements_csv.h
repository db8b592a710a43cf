#pragma once

#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "adapt/adaptation.h"
#include "io/csv_columns.h"
#include "io/csv_table.h"

namespace tissue {

/// Reads measurements from a CSV stream, line by line. Columns are those of measured contacts (results/FORMATS.md), in
/// space also contact_z, displacement_z and force_z. Columns push, repeat and role are allowed and ignored.
class MeasurementLines {
   public:
    /// D: dimension. Throws FileError when the file cannot be read.
    MeasurementLines(const std::string& file, int D) : lines_(file), D_(D) {}
    /// in: must outlive this object. name: used in messages in place of a file name.
    MeasurementLines(std::istream& in, const std::string& name, int D) : lines_(in, name), D_(D) {}

    struct Row {
        int line;           ///< in the file
        ForceMeasurement poke;
        std::string fault;  ///< why the line is invalid, with its place; `poke` is then empty
    };
    /// The next row; absent at the end. Throws FileError with file, line, column and cause for an invalid header, and
    /// for a line of more than 1 MiB.
    std::optional<Row> next();

   private:
    CsvTable lines_;
    CsvColumns columns_;
    int D_;
};

/// All measurements of a file. Throws FileError with the place of the first invalid line, or where there are no rows.
std::vector<ForceMeasurement> read_measurements(const std::string& file, int D);

}  // namespace tissue
