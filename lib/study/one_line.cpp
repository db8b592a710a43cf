#include "study/one_line.h"

#include <fmt/format.h>

namespace tissue {

std::string one_line(const std::string& text) {
    std::string line;
    for (const unsigned char c : text)
        if (c < 32 || c == 127) line += fmt::format("\\x{:02x}", c);
        else line += static_cast<char>(c);
    return line;
}

}  // namespace tissue
