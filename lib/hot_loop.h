#pragma once

/// Marks a loop of the tick that the compiler shall build for wide registers as well; the machine's own width is
/// chosen once, when the program is loaded; before a sanitizer is there to see it, so not under one.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TISSUE_HOT __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define TISSUE_HOT
#endif

/// Marks a function that such a loop calls: the compiler does not build a loop with a call in it for wide registers, so the function has to be inlined.
#if defined(__GNUC__)
#define TISSUE_INLINE inline __attribute__((always_inline))
#else
#define TISSUE_INLINE inline
#endif
