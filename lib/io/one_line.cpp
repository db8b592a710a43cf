#include "io/one_line.h"

#include <fmt/format.h>

#include <algorithm>

namespace tissue {
namespace {

/// Length of the UTF-8 character that begins here; 0: there is none.
std::size_t utf8_length(const std::string& text, std::size_t i) {
    const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u; };
    const unsigned c = byte(i);
    const std::size_t length = c < 0x80 ? 1 : c >= 0xC2 && c < 0xE0 ? 2 : c >= 0xE0 && c < 0xF0 ? 3 : c >= 0xF0 && c < 0xF5 ? 4 : 0;
    for (std::size_t k = 1; k < length; ++k)
        if ((byte(i + k) & 0xC0u) != 0x80) return 0;
    return length;
}

}  // namespace


std::string one_line(const std::string& text) {
    std::string line;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        const std::size_t length = utf8_length(text, i);
        const bool control = c < 32 || c == 127 || length == 0 || (c == 0xC2 && static_cast<unsigned char>(text[i + 1]) < 0xA0);
        if (control) {
            for (std::size_t k = 0; k < std::max<std::size_t>(length, 1); ++k) line += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i + k]));
        } else {
            line.append(text, i, length);
        }
        i += std::max<std::size_t>(length, 1) - 1;
    }
    return line;
}

}  // namespace tissue
