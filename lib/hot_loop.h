#pragma once

/// Marks a loop of the tick that the compiler also builds for wide vector registers. The version for the machine's
/// width is chosen once, when the program is loaded. At that time a sanitizer is not initialised yet, so the attribute
/// is left out under address and thread sanitizers.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TISSUE_HOT __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define TISSUE_HOT
#endif

/// Marks a function that such a loop calls. The compiler does not vectorise a loop that contains a call, so the
/// function has to be inlined.
#if defined(__GNUC__)
#define TISSUE_INLINE inline __attribute__((always_inline))
#else
#define TISSUE_INLINE inline
#endif
