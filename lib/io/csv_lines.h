#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace tissue {

/// The comma-separated fields of one file, line by line; errors name the place. Does not support quotes: for files that
/// programs write. Files that people write are read by CsvTable (io/csv_table.h). At most 1 MiB per line and 256
/// fields.
class CsvLines {
   public:
    static constexpr std::size_t longest_line = std::size_t{1} << 20;

    CsvLines(const CsvLines&) = delete;
    CsvLines& operator=(const CsvLines&) = delete;

    /// Throws FileError when the file cannot be read.
    explicit CsvLines(const std::string& file);
    /// Reads lines as they arrive; `name` names the stream in messages. The stream must outlive the object.
    CsvLines(std::istream& in, std::string name) : file_(std::move(name)), in_(&in) {}

    /// Advances to the next line; false at the end. Accepts line ends of any system. Throws FileError for a line that
    /// is too long.
    bool next();

    const std::string& text() const { return text_; }  ///< the line
    int number() const { return number_; }             ///< number of the line, from 1
    std::size_t size() const { return fields_.size(); }
    const std::string& field(std::size_t i) const { return fields_[i]; }

    /// A field as a finite number. In files of people (CsvTable) spaces around it and a leading + are ignored. Throws
    /// FileError with the place and, if given, the column's name.
    double number(std::size_t i, const std::string& column = "") const;

    /// Throws FileError: "FILE:LINE: WHY".
    [[noreturn]] void refuse(const std::string& why) const;

    virtual ~CsvLines() = default;

   protected:
    static constexpr std::size_t most_fields = 256;

    virtual bool of_people() const { return false; }

    bool next_text();  ///< reads the line without splitting it
    [[noreturn]] void refuse_fields() const;

    std::string text_;
    std::vector<std::string> fields_;

   private:
    std::string file_;
    std::istringstream read_;
    std::istream* in_ = &read_;
    int number_ = 0;
    bool after_return_ = false;  ///< the last line ended with a carriage return; a line feed that follows belongs to it
};

}  // namespace tissue
