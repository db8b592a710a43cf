#pragma once

#include "error.h"

namespace tissue {

/// No indentation is possible at this place of the surface: all nodes of the contact are fixed.
struct FixedContactError : MismatchError {
    using MismatchError::MismatchError;
};

/// The lattice has no tissue near this place of the surface.
struct NoContactError : MismatchError {
    using MismatchError::MismatchError;
};

/// The contacts of two tools would overlap.
struct OverlappingToolsError : MismatchError {
    using MismatchError::MismatchError;
};

}  // namespace tissue
