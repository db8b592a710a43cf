#pragma once

#include <string>

namespace tissue {

/// Whether a text can name a dataset or a part of a path: not empty, "." or "..", and without "/" and control
/// characters.
bool can_name_a_dataset(const std::string& text);

}  // namespace tissue
