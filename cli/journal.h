#pragma once

#include <string>

#include "haptic/learner.h"

namespace tissue::cli {

/// Measurements that a session learned from, as a CSV; `tissuectl adapt --live` makes the same model of it. Each row is
/// written to the system at once: if the session is killed, at most the last measurement is missing. A later session of
/// the same name does not overwrite it.
class Journal {
   public:
    /// file: empty: none is kept. Throws FileError when the file cannot be written, when another session writes it, or
    /// when it is neither empty nor a journal without rows.
    Journal(const std::string& file, int dimension);
    ~Journal();
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;

    void add(const Learner::Line& line);
    /// Call after the last row. Throws FileError when the disk refused a row: that row and all later ones are missing,
    /// and no part of it is in the file.
    void close();

   private:
    bool write(const std::string& line);

    std::string file_;
    int out_ = -1;
    bool shared_ = false;  ///< a descriptor that was already open, to which others may write
    bool whole_ = true;
};

}  // namespace tissue::cli
