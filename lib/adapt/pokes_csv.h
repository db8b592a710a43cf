#pragma once

#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "adapt/adaptation.h"
#include "io/csv_columns.h"
#include "io/csv_table.h"

namespace tissue {

/// Pokes out of a CSV, one by one as they come: the columns of measured contacts (results/FORMATS.md), with contact_z, displacement_z
/// and force_z in space; push, repeat and role may be there and say nothing.
class PokeLines {
   public:
    /// D: axes. Throws FileError when the file cannot be read.
    PokeLines(const std::string& file, int D) : lines_(file), D_(D) {}
    /// in: must outlive it; name stands for the file in messages.
    PokeLines(std::istream& in, const std::string& name, int D) : lines_(in, name), D_(D) {}

    struct Row {
        int line;           ///< in the file
        Poke poke;
        std::string fault;  ///< why the line is none, with its place; then there is no poke
    };
    /// The next one; nothing at the end. A header that is none throws FileError with file, line, column and cause, and so does a line of more than 1 MiB.
    std::optional<Row> next();

   private:
    CsvTable lines_;
    CsvColumns columns_;
    int D_;
};

/// All pokes of a file. Throws FileError with the place of the first line that is none, or where there is no line.
std::vector<Poke> read_pokes(const std::string& file, int D);

}  // namespace tissue
