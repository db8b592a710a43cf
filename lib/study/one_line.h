#pragma once

#include <string>

namespace tissue {

/// A text for a message, which is one line whatever a person wrote: control characters become \xNN.
std::string one_line(const std::string& text);

}  // namespace tissue
