#include "progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <iostream>

namespace tissue::cli {

Progress::Progress(std::string stage)
    : stage_(std::move(stage)), start_(std::chrono::steady_clock::now()), terminal_(isatty(STDERR_FILENO)) {}

Progress::~Progress() {
    if (open_line_) std::cerr << '\n';
}

void Progress::step(int done, int total, const std::string& what) {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
    const double left = spent.count() * (total - done) / done;
    const std::string line = fmt::format("{} [{}/{}] {}, {:.1f} s, about {:.0f} s left", stage_, done, total, what,
                                         spent.count(), left);
    if (terminal_) {
        std::cerr << "\r\033[K" << line << std::flush;
        open_line_ = true;
    } else {
        std::cerr << line << '\n';
    }
}

}  // namespace tissue::cli
