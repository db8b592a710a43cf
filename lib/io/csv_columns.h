#pragma once

#include <map>
#include <string>
#include <vector>

#include "io/csv_lines.h"

namespace tissue {

/// Unit name -> its value in SI.
using Units = std::map<std::string, double>;
const Units& length_units();  ///< m, mm
const Units& force_units();   ///< N, mN
const Units& time_units();    ///< s, ms

/// A column that a kind of CSV may have.
struct CsvColumn {
    std::string name;
    const Units* units;  ///< nullptr: the column is text
    bool required;
};

/// The columns of a CSV whose header states a unit for each: "contact_x [mm],force_y [mN],role", in any order.
class CsvColumns {
   public:
    /// No columns yet.
    CsvColumns() = default;
    /// header: the header line. Throws FileError with file, line, column and cause: a column that is missing, unknown
    /// or there twice, or a unit that is missing or of another kind.
    CsvColumns(const CsvLines& header, const std::vector<CsvColumn>& known);

    bool empty() const { return columns_ == 0; }
    bool has(const std::string& name) const { return place_.count(name) > 0; }

    /// Throws FileError where a line has another number of fields than the header.
    void check(const CsvLines& line) const;
    /// A field in SI units. Throws FileError with the place where it is not a finite number.
    double number(const CsvLines& line, const std::string& name) const;
    /// trimmed; empty where there is no such column
    std::string text(const CsvLines& line, const std::string& name) const;

   private:
    std::map<std::string, std::size_t> place_;
    std::map<std::string, double> unit_;
    std::size_t columns_ = 0;
};

/// Without spaces and tabs at either end.
std::string trimmed(const std::string& text);

}  // namespace tissue
