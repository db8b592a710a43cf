#pragma once

#include <catch2/catch.hpp>
#include <string>

namespace tissue {

/// What a refusal says. Fails the test when `act` does not end in an Error of this type, or when its text is not the
/// one line that error.h promises. Another type of exception fails the test by itself.
template <class Error, class Act>
std::string refusal(Act&& act) {
    try {
        act();
    } catch (const Error& e) {
        const std::string text = e.what();
        CHECK(text.find('\n') == std::string::npos);
        return text;
    }
    FAIL_CHECK("was not refused");
    return "";
}

}  // namespace tissue
