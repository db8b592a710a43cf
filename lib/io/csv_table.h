#pragma once

#include <string>

#include "io/csv_lines.h"

namespace tissue {

/// A CSV that people made: by a spreadsheet, by hand, by a robot's program. UTF-8 with or without a byte order mark; line ends of any system; fields
/// separated by commas, semicolons or tabs, whichever the header has most of; fields in quotes (libcsv). Lines that begin with '#' are
/// comments. Separators at the end of a line, with nothing behind them, make no fields beyond the header's. Another encoding is refused by its name, and so is a quote that does not end on its line.
class CsvTable : public CsvLines {
   public:
    using CsvLines::CsvLines;

    /// To the next line that is not blank; false at the end. A comment has no fields.
    bool next();
    /// To the next line that is no comment either.
    bool next_row() {
        while (next())
            if (!is_comment()) return true;
        return false;
    }
    bool is_comment() const { return text()[0] == '#'; }

   private:
    bool of_people() const override { return true; }
    void check_encoding();
    void split();

    char separator_ = 0;       ///< not known before the header
    std::size_t columns_ = 0;  ///< of the header
};

}  // namespace tissue
