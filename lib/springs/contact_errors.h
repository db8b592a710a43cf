#pragma once

#include "error.h"

namespace tissue {

/// A place of the surface that cannot be pressed: all nodes of its contact are fixed.
struct FixedContactError : MismatchError {
    using MismatchError::MismatchError;
};

/// A place of a solid near which its lattice has no tissue.
struct NoContactError : MismatchError {
    using MismatchError::MismatchError;
};

/// Two tools whose contacts would overlap.
struct OverlappingToolsError : MismatchError {
    using MismatchError::MismatchError;
};

}  // namespace tissue
