#pragma once

#include <fstream>
#include <string>

#include "haptic/learner.h"

namespace tissue::cli {

/// What a session learned, as a CSV that `tissuectl adapt --place_error 1` learns the same from. A row is with the system as soon as it is learned: of a
/// session that is killed all readings but the last stay.
class Journal {
   public:
    /// Empty: none is kept. Throws FileError when it cannot be written.
    Journal(const std::string& file, int dimension);
    void add(const Learner::Line& line);
    /// After the last row. Throws FileError when the disk refused one: then that and all later ones are missing.
    void close();

   private:
    std::string file_;
    std::ofstream out_;
};

}  // namespace tissue::cli
