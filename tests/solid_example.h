#pragma once

#include <string>

namespace tissue {

/// A complete study of a solid block on a 5 x 4 x 3 lattice, with four training paths, three drawn roles and a nodule,
/// and without a map. The section [nodule] is the last one.
const std::string& solid_study_text();

}  // namespace tissue
