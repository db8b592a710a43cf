#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace tissue {

/// The comma-separated fields of one file, line by line, with refusals that name the place. Knows no quotes.
class CsvLines {
   public:
    CsvLines(const CsvLines&) = delete;
    CsvLines& operator=(const CsvLines&) = delete;

    /// Throws FileError when the file cannot be read.
    explicit CsvLines(const std::string& file);
    /// Lines as they come; `name` stands for the file. The stream must outlive it.
    CsvLines(std::istream& in, std::string name) : file_(std::move(name)), in_(&in) {}

    /// To the next line; false at the end. Line ends of any system.
    bool next();

    const std::string& text() const { return text_; }  ///< of the line
    int number() const { return number_; }             ///< of the line, from 1
    std::size_t size() const { return fields_.size(); }
    const std::string& field(std::size_t i) const { return fields_[i]; }

    /// A field as a finite number. Throws FileError with the place and, if given, the column's name.
    double number(std::size_t i, const std::string& column = "") const;

    /// Throws FileError: "FILE:LINE: WHY".
    [[noreturn]] void refuse(const std::string& why) const;

   private:
    std::string file_, text_;
    std::istringstream read_;
    std::istream* in_ = &read_;
    std::vector<std::string> fields_;
    int number_ = 0;
};

}  // namespace tissue
