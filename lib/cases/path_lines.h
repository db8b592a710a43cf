#pragma once

#include <string>

#include "field.h"
#include "io/csv_lines.h"

namespace tissue {

/// Rows of FreeFEM's result files. The first field is the kind of row.
class PathLines : public CsvLines {
   public:
    using CsvLines::CsvLines;

    const std::string& kind() const;

    void want(std::size_t count) const;           ///< refuses a row with another number of fields
    void want_at_least(std::size_t count) const;  ///< refuses a row with fewer fields

    /// The D numbers from field `from` on.
    Point point(std::size_t from, std::size_t D) const;

    /// The text from field i to the end of the row, with commas, as one line for messages (io/one_line.h).
    std::string text_from(std::size_t i) const;
};

}  // namespace tissue
