#include "io/csv_lines.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "error.h"
#include "io/atomic_file.h"

namespace tissue {

CsvLines::CsvLines(const std::string& file) : file_(file), read_(read_file(file)) {}

bool CsvLines::next() {
    if (!std::getline(*in_, text_)) return false;
    if (!text_.empty() && text_.back() == '\r') text_.pop_back();
    ++number_;
    fields_.clear();
    std::istringstream split(text_);
    for (std::string field; std::getline(split, field, ',');) fields_.push_back(field);
    return true;
}

double CsvLines::number(std::size_t i, const std::string& column) const {
    const std::string& field = fields_[i];
    double value = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value))
        refuse(fmt::format("{} is '{}', not a finite number",
                           column.empty() ? fmt::format("field {}", i + 1) : "column '" + column + "'", field));
    return value;
}

void CsvLines::refuse(const std::string& why) const {
    throw FileError(fmt::format("{}:{}: {}", file_, number_, why));
}

}  // namespace tissue
