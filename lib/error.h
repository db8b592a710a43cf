#pragma once

#include <stdexcept>
#include <string>

namespace tissue {

/// Base of everything this library throws: what the caller got wrong or the disk did. Its text is one line that
/// names file, place and cause. Non-convergence is a status, never an exception.
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A study file that cannot be read, or a key or value in it that is not allowed.
struct StudyError : Error {
    using Error::Error;
};

/// A data file that is missing, truncated, foreign, of another format version, or cannot be written.
struct FileError : Error {
    using Error::Error;
};

/// Pieces that do not fit together: a contact off the surface, cases of another mesh.
struct MismatchError : Error {
    using Error::Error;
};

}  // namespace tissue
