#pragma once

#include <string>

namespace tissue {

/// A text as one line for a message: control characters, and bytes that are not UTF-8, become \xNN, because a terminal
/// would execute them.
std::string one_line(const std::string& text);

}  // namespace tissue
