#pragma once

#include <cfenv>
#include <limits>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace tissue {

/// Floating-point mode of the calling thread: control word of the processor (x86-64; elsewhere 0), whether denormals
/// are numbers, found by trial, and rounding mode (0: to nearest).
struct FloatMode {
    unsigned word;
    bool denormals;
    int rounding;
    bool operator==(const FloatMode& o) const { return word == o.word && denormals == o.denormals && rounding == o.rounding; }
};

inline FloatMode float_mode() {
    FloatMode mode{0, false, std::fegetround()};
#if defined(__x86_64__)
    mode.word = _mm_getcsr() & ~0x3fu;  // without the exception flags
    mode.rounding = static_cast<int>(mode.word & 0x6000);  // of SSE; fegetround() reads the x87 unit
#endif
    volatile double small = std::numeric_limits<double>::min();
    small = small / 2;
    mode.denormals = small * 4 > 0;
    return mode;
}

}  // namespace tissue
