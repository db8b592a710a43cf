#include "surface_file/text_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "error.h"
#include "surface_file/facets.h"

namespace tissue::surface_file {
namespace {

constexpr std::string_view blanks = " \t\r\v\f";

template <class Number>
bool reads(std::string_view word, Number& value) {
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string_view take_word(std::string_view& text) {
    text = trimmed(text);
    const std::string_view word = text.substr(0, text.find_first_of(blanks));
    text.remove_prefix(word.size());
    return word;
}

bool is_word(std::string_view text, std::string_view lower) {
    return text.size() == lower.size() && std::equal(text.begin(), text.end(), lower.begin(), [](unsigned char a, char b) { return std::tolower(a) == b; });
}

std::string_view TextLines::next() {
    while (!text_.empty()) {
        const std::size_t end = std::min(text_.find_first_of("\n\r"), text_.size());
        std::string_view line = text_.substr(0, end);
        text_.remove_prefix(std::min(end + (text_.substr(end, 2) == "\r\n" ? 2 : 1), text_.size()));
        ++number_;
        if (comment_ != 0) line = line.substr(0, line.find(comment_));
        if (line = trimmed(line); !line.empty()) return line;
    }
    return {};
}

std::string_view TextLines::want(const char* whole) {
    const std::string_view line = next();
    if (line.empty()) throw FileError(fmt::format("{}: is truncated: '{}' is missing", file_, whole));
    return line;
}

double TextLines::take_real(std::string_view& line, const char* whole) const {
    double value = 0;
    if (!reads(take_word(line), value)) refuse(fmt::format("is not '{}'", whole));
    return value;
}

double TextLines::take_number(std::string_view& line, const char* whole) const {
    const double value = take_real(line, whole);
    if (!(std::abs(value) <= largest_coordinate)) refuse(fmt::format("has a coordinate that is not a finite number, or beyond {:g}", largest_coordinate));
    return value;
}

long long TextLines::take_count(std::string_view& line, const char* whole) const {
    long long value = 0;
    if (!reads(take_word(line), value)) refuse(fmt::format("is not '{}'", whole));
    return value;
}

void TextLines::refuse(const std::string& why) const { throw FileError(fmt::format("{}:{}: {}", file_, number_, why)); }

}  // namespace tissue::surface_file
