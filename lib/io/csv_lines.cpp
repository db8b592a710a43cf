#include "io/csv_lines.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "error.h"
#include "io/atomic_file.h"

namespace tissue {

CsvLines::CsvLines(const std::string& file) : file_(file), read_(read_file(file)) {}

bool CsvLines::next_text() {
    text_.clear();
    if (!in_->good()) return false;
    std::streambuf& bytes = *in_->rdbuf();
    for (bool any = false;; any = true) {
        const int byte = bytes.sbumpc();
        if (byte == std::streambuf::traits_type::eof()) {
            in_->setstate(std::ios::eofbit);
            if (!any) return false;
            break;
        }
        if (byte == '\n' && !any && after_return_) {
            after_return_ = false;
            return next_text();
        }
        after_return_ = byte == '\r';
        if (byte == '\n' || byte == '\r') break;
        text_ += static_cast<char>(byte);
        if (text_.size() > longest_line) {
            ++number_;
            refuse(fmt::format("has more than {} bytes in one line", longest_line));
        }
    }
    ++number_;
    return true;
}

bool CsvLines::next() {
    if (!next_text()) return false;
    fields_.clear();
    std::istringstream split(text_);
    for (std::string field; std::getline(split, field, ',');) {
        fields_.push_back(field);
        if (fields_.size() > most_fields) refuse_fields();
    }
    return true;
}

void CsvLines::refuse_fields() const { refuse(fmt::format("has more than {} fields", most_fields)); }

double CsvLines::number(std::size_t i, const std::string& column) const {
    const std::string& field = fields_[i];
    const auto blank = [](char c) { return c == ' ' || c == '\t'; };
    const char *begin = field.data(), *last = begin + field.size();
    while (of_people() && begin < last && blank(*begin)) ++begin;
    while (of_people() && begin < last && blank(last[-1])) --last;
    // some programs write a +, which std::from_chars does not accept
    if (of_people() && last - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
    double value = 0;
    const auto [end, error] = std::from_chars(begin, last, value);
    if (error != std::errc() || end != last || !std::isfinite(value))
        refuse(fmt::format("{} is '{}', not a finite number{}", column.empty() ? fmt::format("field {}", i + 1) : "column '" + column + "'", field,
                           field.find(',') != std::string::npos ? "; write a decimal point, not a comma, and no separator between thousands" : ""));
    return value;
}

void CsvLines::refuse(const std::string& why) const {
    throw FileError(fmt::format("{}:{}: {}", file_, number_, why));
}

}  // namespace tissue
