#pragma once

#include "error.h"

namespace tissue {

/// A device cannot be opened: a library or a port is missing, or a recording is empty.
struct DeviceError : Error {
    using Error::Error;
};

}  // namespace tissue
