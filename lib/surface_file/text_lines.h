#pragma once

#include <string>
#include <string_view>

namespace tissue::surface_file {

std::string_view trimmed(std::string_view text);
/// The first word of a text, which goes on behind it.
std::string_view take_word(std::string_view& text);
/// Whether it is this word in small letters, in capitals or not.
bool is_word(std::string_view text, std::string_view lower);

/// A text by its lines, of which messages give the number. Lines end as those of Linux, Windows or old Macs.
class TextLines {
   public:
    /// comment: what of a line stands behind this does not count, if it is not 0.
    TextLines(const std::string& file, std::string_view text, char comment = 0) : file_(file), text_(text), comment_(comment) {}

    /// The next line that is not blank, trimmed; empty at the end of the file.
    std::string_view next();
    /// As next. Throws FileError at the end of the file: `whole` should stand there.
    std::string_view want(const char* whole);
    /// The next word of a line of this form, as a number, infinite or not a number too.
    double take_real(std::string_view& line, const char* whole) const;
    /// As take_real; any but a finite one up to largest_coordinate is refused.
    double take_number(std::string_view& line, const char* whole) const;
    /// The next word as a whole number.
    long long take_count(std::string_view& line, const char* whole) const;
    long number() const { return number_; }          ///< of the last line
    std::string_view rest() const { return text_; }  ///< what follows it
    [[noreturn]] void refuse(const std::string& why) const;  ///< FileError: FILE:LINE: why

   private:
    const std::string& file_;
    std::string_view text_;
    char comment_;
    long number_ = 0;
};

}  // namespace tissue::surface_file
