#pragma once

#include <chrono>
#include <string>

namespace tissue::cli {

/// Progress of long work on standard error, with the time left. On a terminal one line that is rewritten; otherwise one
/// line per step.
class Progress {
   public:
    explicit Progress(std::string stage);
    ~Progress();
    void step(int done, int total, const std::string& what);

   private:
    std::string stage_;
    std::chrono::steady_clock::time_point start_;
    bool terminal_, open_line_ = false;
};

}  // namespace tissue::cli
