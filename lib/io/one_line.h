#pragma once

#include <string>

namespace tissue {

/// A text for a message, which is one line whatever a person wrote: control characters, and bytes that are
/// no UTF-8, become \xNN. A terminal obeys them.
std::string one_line(const std::string& text);

}  // namespace tissue
