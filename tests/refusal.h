#pragma once

#include <catch2/catch.hpp>
#include <string>

namespace tissue {

/// Text of the Error that `act` throws. The test fails if `act` throws no Error, or if the text is not the one line
/// that error.h promises. An exception of another type fails the test too.
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
