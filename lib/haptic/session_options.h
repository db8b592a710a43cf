#pragma once

#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "haptic/simulation.h"

namespace tissue {

/// Where a session option exists, and when it may change; flags, which are added. interfaces: C and Python. live: may
/// change while a session runs. limits: limits of the device, which may change until the session's first tick.
enum Where : unsigned { tissue_haptic = 1, tissuectl_serve = 2, interfaces = 4 /* C and Python */, programs = 3, everywhere = 7, live = 8 /* while a session runs */, limits = 16 /* until its first tick */ };

/// Allowed values of an option: an interval of numbers, or a list of words. Infinity is allowed only where an end
/// includes it.
struct Allowed {
    double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
    bool with_low = false, with_high = false;  ///< whether the end itself is allowed
    std::vector<std::string> words = {};       ///< empty: any text, or a number
    bool takes(double value) const { return (value > low || (with_low && value == low)) && (value < high || (with_high && value == high)); }
};

/// A field of HapticOptions that users can set. Options of programs, C and Python, help texts, man pages, completions
/// and lib/api/OPTIONS.md are generated from these rows.
struct SessionOption {
    template <class T> using Of = T& (*)(HapticOptions&);
    /// name: `-` between words, in Python `_`. unit: SI, "1" for a ratio, or the kind of text
    const char *name, *unit;
    Allowed allowed;
    unsigned where;
    std::variant<Of<double>, Of<std::optional<double>>, Of<int>, Of<bool>, Of<std::string>, Of<SelectBy>, Of<ToolChoices>, Of<decltype(DeviceMap::axes)>, Of<Point>> field;
    std::string meaning, more;           ///< one line; further explanation
    const char* unset = "";              ///< effective default of a field that is empty by default

    bool is_number() const { return field.index() < 3 || is_list(); }
    /// yes or no; in a program a flag, --NAME, or --no-NAME where it is on by default
    bool is_switch() const { return std::holds_alternative<Of<bool>>(field); }
    bool is_list() const { return std::holds_alternative<Of<Point>>(field); }    ///< two or three numbers
    std::string values() const;                            ///< allowed values: "(0, inf)", "yes, no"; "": any text
    std::string initial(Where place) const;                ///< default as text; "" where there is none
    /// Sets the field from text. Throws MismatchError for a text that is not a value of this option.
    void set(HapticOptions& options, const std::string& text) const;
    /// Throws MismatchError for a number outside the range, with the same message in programs, C and Python: "force-max
    /// must lie in (0, inf) N, not -1".
    void check(HapticOptions options) const;
};

/// All session options, in the order in which help and documents list them.
const std::vector<SessionOption>& session_options();

/// Default options of a session in C or Python. There is no heuristic mesh, since their programs draw their own scene.
/// The device holds a force for 2 longest_dt_s (0.05 s), which suits a host of 50 Hz whose periods vary by 5 ms.
HapticOptions interface_options();

/// Sets one option by name, from text. changeable: flags of the options that may change: `everywhere` before a session
/// exists, `live | limits` until its first tick, then `live`. Throws MismatchError as SessionOption::set, for an
/// unknown name, and for an option without any of these flags.
void set_option(HapticOptions& options, const std::string& name, const std::string& value, unsigned changeable = everywhere);

/// Flags of the options of a session that may still change.
inline unsigned changeable(const Simulation& session) { return session.has_begun() ? live : live | limits; }

}  // namespace tissue
