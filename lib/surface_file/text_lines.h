#pragma once

#include <string>
#include <string_view>

namespace tissue::surface_file {

/// A text without blanks at its ends.
std::string_view trimmed(std::string_view text);
/// Takes the first word off a text.
std::string_view take_word(std::string_view& text);
/// Whether a text is a given word, in any case. lower: the word in small letters.
bool is_word(std::string_view text, std::string_view lower);

/// Reads a text line by line and counts the lines for messages. Line ends may be LF, CR LF or CR.
class TextLines {
   public:
    /// file: name for messages. comment: the rest of a line from this character on is ignored; 0: no comments.
    TextLines(const std::string& file, std::string_view text, char comment = 0) : file_(file), text_(text), comment_(comment) {}

    /// The next line that is not blank, trimmed; empty at the end of the text.
    std::string_view next();
    /// As next, but throws FileError at the end of the text. whole: the expected line, for the message.
    std::string_view want(const char* whole);
    /// Takes the next word off a line as a number; infinity and NaN are allowed. Throws FileError if it is no number.
    /// whole: the line's form, for the message.
    double take_real(std::string_view& line, const char* whole) const;
    /// As take_real, but throws FileError also if the number is not finite or beyond largest_coordinate.
    double take_number(std::string_view& line, const char* whole) const;
    /// As take_real, for an integer.
    long long take_count(std::string_view& line, const char* whole) const;
    long number() const { return number_; }          ///< of the last line, from 1
    std::string_view rest() const { return text_; }  ///< the text after it
    [[noreturn]] void refuse(const std::string& why) const;  ///< throws FileError "FILE:LINE: why"

   private:
    const std::string& file_;
    std::string_view text_;
    char comment_;
    long number_ = 0;
};

}  // namespace tissue::surface_file
