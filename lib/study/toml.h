#pragma once

#include <cassert>
#include <stdexcept>

namespace tissue {

/// A malformed text has reached a state that toml++ asserts it cannot (3.3: "[,", "a = {b = ,").
struct TomlAssertion : std::logic_error {
    using std::logic_error::logic_error;
};

[[noreturn]] inline void toml_assertion_failed(const char* what) {
    throw TomlAssertion(what);
}

}  // namespace tissue

// The only way to toml++. Its assertions throw, in every build: where NDEBUG is defined it would turn some of them into
// promises to the compiler, and a malformed text into undefined behaviour.
#ifdef TOML_ASSERT
#error "include study/toml.h before toml++"
#endif
#define TOML_UNDEF_MACROS 1
#define TOML_ASSERT(expression) (static_cast<bool>(expression) ? void() : ::tissue::toml_assertion_failed(#expression))
#pragma push_macro("NDEBUG")
#undef NDEBUG
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")
#include <cassert>  // as NDEBUG has it again
