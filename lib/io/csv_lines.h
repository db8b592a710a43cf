#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace tissue {

/// The comma-separated fields of one file, line by line, with refusals that name the place. Knows no quotes: for what programs write, and
/// what people do is read by CsvTable (io/csv_table.h). At most 1 MiB a line and 256 fields.
class CsvLines {
   public:
    static constexpr std::size_t longest_line = std::size_t{1} << 20;

    CsvLines(const CsvLines&) = delete;
    CsvLines& operator=(const CsvLines&) = delete;

    /// Throws FileError when the file cannot be read.
    explicit CsvLines(const std::string& file);
    /// Lines as they come; `name` stands for the file. The stream must outlive it.
    CsvLines(std::istream& in, std::string name) : file_(std::move(name)), in_(&in) {}

    /// To the next line; false at the end. Line ends of any system. Throws FileError for a line that is too long.
    bool next();

    const std::string& text() const { return text_; }  ///< of the line
    int number() const { return number_; }             ///< of the line, from 1
    std::size_t size() const { return fields_.size(); }
    const std::string& field(std::size_t i) const { return fields_[i]; }

    /// A field as a finite number; where people write, blanks about it and a leading + are passed over. Throws FileError with the place and, if given, the column's name.
    double number(std::size_t i, const std::string& column = "") const;

    /// Throws FileError: "FILE:LINE: WHY".
    [[noreturn]] void refuse(const std::string& why) const;

    virtual ~CsvLines() = default;

   protected:
    static constexpr std::size_t most_fields = 256;

    virtual bool of_people() const { return false; }

    bool next_text();  ///< the line alone, no fields
    [[noreturn]] void refuse_fields() const;

    std::string text_;
    std::vector<std::string> fields_;

   private:
    std::string file_;
    std::istringstream read_;
    std::istream* in_ = &read_;
    int number_ = 0;
    bool after_return_ = false;  ///< a line feed that comes next ends no line of its own
};

}  // namespace tissue
