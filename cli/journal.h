#pragma once

#include <string>

#include "haptic/learner.h"

namespace tissue::cli {

/// What a session learned, as a CSV that `tissuectl adapt --live` learns the same from. A row is with the system as soon as it is learned: of a
/// session that is killed all readings but the last stay, and no later session of the same name takes them away.
class Journal {
   public:
    /// Empty: none is kept. Throws FileError when it cannot be written, when another session writes it, or when it is a file that is
    /// neither empty nor a journal without rows.
    Journal(const std::string& file, int dimension);
    ~Journal();
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;

    void add(const Learner::Line& line);
    /// After the last row. Throws FileError when the disk refused one: that and all later ones are missing, and no part of it stands there.
    void close();

   private:
    bool write(const std::string& line);

    std::string file_;
    int out_ = -1;
    bool shared_ = false;  ///< a descriptor that was open already, which others may write to
    bool whole_ = true;
};

}  // namespace tissue::cli
