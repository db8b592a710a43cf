#pragma once

#include <string>
#include <vector>

#include "haptic/simulation.h"

namespace tissue {

/// Names that set_option knows, in the order of tissue.h.
std::vector<std::string> session_option_names();

/// One option of a session by its name (tissue.h) and as text. Throws MismatchError for a name that is none, or a text that is no value of it.
void set_option(HapticOptions& options, const std::string& name, const std::string& value);

}  // namespace tissue
