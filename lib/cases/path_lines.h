#pragma once

#include <string>

#include "field.h"
#include "io/csv_lines.h"

namespace tissue {

/// FreeFEM's rows: the first field is the kind of row.
class PathLines : public CsvLines {
   public:
    using CsvLines::CsvLines;

    const std::string& kind() const;

    void want(std::size_t count) const;           ///< refuses another number of fields
    void want_at_least(std::size_t count) const;

    /// D numbers, from a field on.
    Point point(std::size_t from, std::size_t D) const;

    /// A last field that may hold commas of its own, as a message may show it (io/one_line.h).
    std::string text_from(std::size_t i) const;
};

}  // namespace tissue
