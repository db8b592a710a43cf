#pragma once

#include "error.h"

namespace tissue {

/// A device that cannot be opened: a library or a port that is missing, a recording that holds nothing.
struct DeviceError : Error {
    using Error::Error;
};

}  // namespace tissue
