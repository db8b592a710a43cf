#pragma once

#include <string>

namespace tissue {

/// Whether a text can name something in a file of ours, where it may stand in a path: not empty, "." or "..", without "/" and control
/// characters.
bool can_name_a_dataset(const std::string& text);

}  // namespace tissue
