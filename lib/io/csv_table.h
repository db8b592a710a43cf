#pragma once

#include <string>

#include "io/csv_lines.h"

namespace tissue {

/// A CSV written by people: by a spreadsheet, by hand, by a robot's program. UTF-8 with or without a byte order mark;
/// line ends of any system; fields separated by commas, semicolons or tabs, whichever is most frequent in the header;
/// fields in quotes (libcsv). Lines that begin with '#' are comments. Trailing separators with nothing after them make
/// no fields beyond those of the header. Refuses another encoding, with its name, and a quote that does not end on its
/// line.
class CsvTable : public CsvLines {
   public:
    using CsvLines::CsvLines;

    /// Advances to the next line that is not blank; false at the end. A comment has no fields.
    bool next();
    /// Advances to the next line that is not a comment either.
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

    char separator_ = 0;       ///< 0: not known before the header
    std::size_t columns_ = 0;  ///< in the header
};

}  // namespace tissue
