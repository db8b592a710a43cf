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

   private:
    std::ofstream out_;
};

/// "program 12.5 s: learned, felt 0.2 N, expected 0.3 N +- 5 %", with a warning's line after it.
std::string told(const std::string& program, const Learner::Line& line);

}  // namespace tissue::cli
