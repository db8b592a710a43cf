// The table of session options. Every row is a field, its default is what a session uses, and check_options() refuses
// values outside its range.
#include "haptic/session_options.h"

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <set>

#include "../refusal.h"
#include "error.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

/// The number as text, twice for a list.
std::string text(const SessionOption& option, double value) {
    const std::string one = fmt::format("{}", value);
    return option.is_list() ? one + " " + one : one;
}

/// Message of check_options() for this value; "" where it is accepted. Other options are set so that only this one can
/// be refused: friction-slip needs friction, dt a hold of twice its length, hold a short dt.
std::string refused(const SessionOption& option, double value) {
    HapticOptions options;
    if (option.name == std::string("friction-slip")) options.friction.stick = 1e300;
    if (option.name == std::string("dt")) options.safety.hold_s = 1;
    if (option.name == std::string("hold")) options.dt_s = 1e-6;
    option.set(options, text(option, value));
    try {
        check_options(options);
    } catch (const MismatchError& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("names of session options are unique and of lower-case letters and hyphens and every option exists somewhere", "[options]") {
    std::set<std::string> names;
    for (const SessionOption& option : session_options()) {
        const std::string name = option.name;
        INFO(name);
        CHECK(names.insert(name).second);
        CHECK(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz-") == std::string::npos);
        CHECK((option.where > 0 && option.where <= (everywhere | live | limits) && (option.where & everywhere)));
        CHECK(option.meaning.find('\n') == std::string::npos);
        CHECK(!option.meaning.empty());
        CHECK(*option.unit);
    }
}

TEST_CASE("the default of a session option is the value that a session uses", "[options]") {
    const HapticModel springs(haptic_example(), {});
    for (const SessionOption& option : session_options()) {
        INFO(option.name);
        const std::string initial = option.initial(programs);
        if (initial.empty() || option.name == std::string("sets")) continue;
        HapticOptions options = springs.options, given = options;
        option.set(given, initial);
        const auto shown = [&](HapticOptions& o) {
            return std::visit([&](auto of) {
                using T = std::decay_t<decltype(of(o))>;
                if constexpr (std::is_same_v<T, std::string>) return of(o);
                else if constexpr (std::is_same_v<T, std::optional<double>>) return std::to_string(of(o).value());
                else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) return std::to_string(static_cast<double>(of(o)));
                else return std::string();
            }, option.field);
        };
        CHECK(shown(options) == shown(given));
    }
    CHECK_FALSE(interface_options().heuristic_mesh);
}

TEST_CASE("a number outside the range of its option is refused with option and range and unit and value", "[options]") {
    constexpr double inf = std::numeric_limits<double>::infinity();
    int numbers = 0;
    for (const SessionOption& option : session_options()) {
        if (!option.is_number()) continue;
        ++numbers;
        const Allowed& a = option.allowed;
        for (const double value : {std::nan(""), -inf, inf, -1.0, 0.0, a.low, a.high, std::nextafter(a.low, -inf), std::nextafter(a.low, inf), std::nextafter(a.high, -inf), std::nextafter(a.high, inf)}) {
            // no text of an int
            if (std::holds_alternative<SessionOption::Of<int>>(option.field) && !(value == std::floor(value) && std::isfinite(value))) continue;
            const std::string why = refused(option, value), unit = option.unit;
            INFO(option.name << " = " << value << ": " << why);
            const bool inside = value == a.low ? a.with_low : value == a.high ? a.with_high : value > a.low && value < a.high;
            // The largest finite number lies inside a range without an end.
            if (inside && std::isfinite(value) && std::abs(value) > 1e299) continue;
            CHECK(why == (inside ? "" : fmt::format("{} must lie in {}{}, not {}", option.name, option.values(), unit == "1" ? "" : " " + unit, value)));
        }
    }
    CHECK(numbers >= 13);
}

TEST_CASE("a text that is no value of its option is refused with the option's name", "[options]") {
    HapticOptions options;
    for (const SessionOption& option : session_options()) {
        INFO(option.name);
        if (option.is_number() || !option.allowed.words.empty())
            for (const char* wrong : {"", "a lot", "1,5", "YES", " "})
                CHECK_THAT(refusal<MismatchError>([&] { option.set(options, wrong); }), Catch::Matchers::StartsWith(option.name));
        for (const std::string& word : option.allowed.words) option.set(options, word);
    }
    CHECK_THAT(refusal<MismatchError>([&] { set_option(options, "offset", "1"); }), Catch::Matchers::Equals("offset must be two or three numbers, not '1'"));
    CHECK_THAT(refusal<MismatchError>([&] { set_option(options, "heuristic", "1"); }), Catch::Matchers::Equals("heuristic must be one of yes, no, not '1'"));
    CHECK_THAT(refusal<MismatchError>([&] { set_option(options, "rotation", "0 0 1 0"); }), Catch::Matchers::StartsWith("rotation must be two or three numbers"));
    // Options of a running session.
    set_option(options, "scale", "2", live);
    CHECK(options.map.scale == 2);
    CHECK_THAT(refusal<MismatchError>([&] { set_option(options, "dt", "0.002", live | limits); }), Catch::Matchers::Equals("option 'dt' cannot change after the session has begun"));
    CHECK_THAT(refusal<MismatchError>([&] { set_option(options, "slew", "1", live); }), Catch::Matchers::Equals("option 'slew' may change only until the first tick"));
    CHECK_THAT(refusal<MismatchError>([&] { set_option(options, "colour", "red"); }), Catch::Matchers::Equals("there is no option 'colour'"));
}
