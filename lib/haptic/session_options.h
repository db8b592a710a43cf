#pragma once

#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "haptic/simulation.h"

namespace tissue {

/// Where a session option exists. A set is a sum.
enum Where : unsigned { tissue_haptic = 1, tissuectl_serve = 2, interfaces = 4 /* C and Python */, programs = 3, everywhere = 7, live = 8 /* may change while a session runs */, limits = 16 /* of a device: may change until the session's first tick */ };

/// The values of an option: an interval of numbers, or a list of words. Infinity belongs to a range only where an end includes it.
struct Allowed {
    double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
    bool with_low = false, with_high = false;  ///< the end itself is allowed
    std::vector<std::string> words = {};       ///< nothing: any, or a number
    bool takes(double value) const { return (value > low || (with_low && value == low)) && (value < high || (with_high && value == high)); }
};

/// A field of HapticOptions that users set. Programs, C, Python, their help, man pages, completions and lib/api/OPTIONS.md are made from these rows.
struct SessionOption {
    template <class T> using Of = T& (*)(HapticOptions&);
    const char *name, *unit;             ///< name: with `-` between words, in Python `_`. unit: SI, 1 of a ratio, or what a text is
    Allowed allowed;
    unsigned where;
    std::variant<Of<double>, Of<std::optional<double>>, Of<int>, Of<bool>, Of<std::string>, Of<SelectBy>, Of<ToolChoice>, Of<decltype(DeviceMap::axes)>, Of<Point>> field;
    std::string meaning, more;           ///< one line, and the rest
    const char* unset = "";              ///< default of a field that is empty by default

    bool is_number() const { return field.index() < 3 || is_list(); }
    bool is_switch() const { return std::holds_alternative<Of<bool>>(field); }  ///< yes or no; of a program a flag: --NAME, or --no-NAME where it is on by default
    bool is_list() const { return std::holds_alternative<Of<Point>>(field); }    ///< two or three numbers
    std::string values() const;                            ///< what it may be: "(0, inf)", "yes, no"; "" where any text may be one
    std::string initial(Where place) const;                ///< default as text, "" where there is none
    /// Throws MismatchError for a text that is no value of it.
    void set(HapticOptions& options, const std::string& text) const;
    /// Throws MismatchError for a number outside the range: "force-max must lie in (0, inf) N, not -1", from programs, C and Python alike.
    void check(HapticOptions options) const;
};

/// In the order in which help and documents list them.
const std::vector<SessionOption>& session_options();

/// What a session of C or Python begins with: no heuristic mesh, as their programs have a scene of their own, and a device that holds a force long enough for a host of 50 Hz whose clock strays by 5 ms.
HapticOptions interface_options();

/// One option by its name and as text. changeable: options that may still change, all before a session exists; then `live`, with `limits` until its first tick. Throws MismatchError as SessionOption::set, for a name that there is not, and for an option that is none of `changeable`.
void set_option(HapticOptions& options, const std::string& name, const std::string& value, unsigned changeable = everywhere);

/// What may still change of a session.
inline unsigned changeable(const Simulation& session) { return session.has_begun() ? live : live | limits; }

}  // namespace tissue
