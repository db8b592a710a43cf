#pragma once

#include <map>
#include <string>
#include <vector>

#include "io/csv_lines.h"

namespace tissue {

/// Names of units, and what one of each is in SI.
using Units = std::map<std::string, double>;
const Units& length_units();  ///< m, mm
const Units& force_units();   ///< N, mN
const Units& time_units();    ///< s, ms

/// A column that a kind of CSV knows.
struct CsvColumn {
    std::string name;
    const Units* units;  ///< none: a text
    bool required;
};

/// The columns of a CSV whose header says a unit each: "contact_x [mm],force_y [mN],role", in any order.
class CsvColumns {
   public:
    /// No columns yet.
    CsvColumns() = default;
    /// header: the line it stands on. Throws FileError with file, line, column and cause: one that is missing, unknown or twice, a unit that
    /// is absent or not one of its kind.
    CsvColumns(const CsvLines& header, const std::vector<CsvColumn>& known);

    bool empty() const { return columns_ == 0; }
    bool has(const std::string& name) const { return place_.count(name) > 0; }

    /// Throws FileError where a line has not as many fields as the header columns.
    void check(const CsvLines& line) const;
    /// In SI. Throws FileError with the place for what is no finite number.
    double number(const CsvLines& line, const std::string& name) const;
    std::string text(const CsvLines& line, const std::string& name) const;  ///< trimmed; empty where there is no such column

   private:
    std::map<std::string, std::size_t> place_;
    std::map<std::string, double> unit_;
    std::size_t columns_ = 0;
};

/// Without blanks and tabs at either end.
std::string trimmed(const std::string& text);

}  // namespace tissue
