#pragma once

#include <cstdint>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace tissue {

/// Sets the calling thread's floating-point mode for the lifetime of this object, then restores the caller's whole
/// mode. The mode: round to nearest, no traps, and numbers below 2.2e-308 (denormals) are zero. Decaying oscillations
/// of the tissue pass through denormals on their way to rest, and a processor takes ten times as long for each
/// operation on them. Sums of ordinary numbers are the same to the last bit. Does nothing on processors other than
/// x86-64 and AArch64.
class FlushDenormals {
   public:
#if defined(__x86_64__)
    FlushDenormals() noexcept : callers_(_mm_getcsr()) { _mm_setcsr(mode); }
    ~FlushDenormals() { _mm_setcsr(callers_); }
    static bool on() noexcept { return (_mm_getcsr() & ~exceptions) == mode; }

   private:
    static constexpr unsigned exceptions = 0x3f;  ///< sticky flags of past exceptions, not part of the mode
    /// bits of MXCSR; the last two: denormal results, and denormal operands, are zero
    static constexpr unsigned mode = 0x1f80 /* no traps, to nearest */ | 0x8000 /* results */ | 0x0040 /* operands */;
    unsigned callers_;
#elif defined(__aarch64__)
    FlushDenormals() noexcept : callers_(control()) { set_control(mode); }
    ~FlushDenormals() { set_control(callers_); }
    static bool on() noexcept { return control() == mode; }

   private:
    static constexpr std::uint64_t mode = std::uint64_t{1} << 24;  // FPCR.FZ: denormal operands and results are zero
    static std::uint64_t control() noexcept {
        std::uint64_t now;
        __asm__ volatile("mrs %0, fpcr" : "=r"(now));
        return now;
    }
    static void set_control(std::uint64_t wanted) noexcept { __asm__ volatile("msr fpcr, %0" ::"r"(wanted)); }
    std::uint64_t callers_;
#else
    FlushDenormals() noexcept {}
    ~FlushDenormals() {}
    static bool on() noexcept { return true; }

   private:
#endif
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;
};

}  // namespace tissue
