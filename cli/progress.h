#pragma once

#include <chrono>
#include <string>

namespace tissue::cli {

/// Progress of long work on standard error: one line with the time left that rewrites itself on a terminal, a plain
/// line a step otherwise.
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
