#pragma once

#include <csignal>
#include <exception>
#include <iostream>
#include <string>

namespace tissue::cli {

/// The reader of the program's output may exit before the program has closed its files.
inline void ignore_broken_pipes() {
    std::signal(SIGPIPE, SIG_IGN);
}

/// Actions at the end of a session, one after the other. Each is done even if one before it failed.
class SessionEnd {
   public:
    explicit SessionEnd(std::string program) : program_(std::move(program)) {}

    template <class Act>
    void then(Act&& act) {
        try {
            act();
        } catch (const std::exception& e) {
            if (first_) std::cerr << program_ << ": " << e.what() << '\n';
            else first_ = std::current_exception();
        }
    }

    /// Throws the first failure; the others were printed when they happened.
    void done() const {
        if (first_) std::rethrow_exception(first_);
    }

   private:
    std::string program_;
    std::exception_ptr first_;
};

}  // namespace tissue::cli
