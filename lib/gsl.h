#pragma once

#include <gsl/gsl_errno.h>
#include <gsl/gsl_rng.h>

#include <memory>
#include <new>

namespace tissue {

/// GSL's default error handler prints and ends the program. This constant switches it off before main(), and in a host
/// program when it loads the library. GSL then returns errors as a status, a NaN or a null pointer, which the caller
/// checks. Every file that uses GSL includes this header.
inline const bool gsl_errors_are_returned = (gsl_set_error_handler_off(), true);

/// A random number generator (mt19937) with a given seed. Throws std::bad_alloc.
using Rng = std::unique_ptr<gsl_rng, void (*)(gsl_rng*)>;
inline Rng seeded_rng(unsigned long seed) {
    Rng rng(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free);
    if (!rng) throw std::bad_alloc();
    gsl_rng_set(rng.get(), seed);
    return rng;
}

}  // namespace tissue
