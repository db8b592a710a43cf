#pragma once

#include <string>

namespace tissue {

/// A whole study of a solid block on a 5 x 4 x 3 lattice, with four load paths, three roles and a nodule: every key of
/// solids once, but a map. The nodule is last.
const std::string& solid_study_text();

}  // namespace tissue
