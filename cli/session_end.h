#pragma once

#include <csignal>
#include <exception>
#include <iostream>
#include <string>

namespace tissue::cli {

/// The reader of the program's output may exit before its files are closed.
inline void ignore_broken_pipes() {
    std::signal(SIGPIPE, SIG_IGN);
}

/// What is left to do when a session has ended, thing after thing: one that fails takes no other with it.
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

    /// Throws the first of what failed; the others are told already.
    void done() const {
        if (first_) std::rethrow_exception(first_);
    }

   private:
    std::string program_;
    std::exception_ptr first_;
};

}  // namespace tissue::cli
