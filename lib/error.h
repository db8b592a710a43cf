#pragma once

#include <stdexcept>
#include <string>

namespace tissue {

/// Base class of this library's exceptions, for errors of the caller and of the disk. what() is one line that names
/// file, place and cause. Non-convergence is a status, never an exception.
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A study file cannot be read, or has a key or value that is not allowed.
struct StudyError : Error {
    using Error::Error;
};

/// A data file is missing, truncated, of another program or format version, or cannot be written.
struct FileError : Error {
    using Error::Error;
};

/// Inputs do not fit together (a contact off the surface, cases of another mesh), or a value is out of range.
struct MismatchError : Error {
    using Error::Error;
};

}  // namespace tissue
