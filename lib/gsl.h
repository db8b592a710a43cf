#pragma once

#include <gsl/gsl_errno.h>
#include <gsl/gsl_rng.h>

#include <memory>
#include <new>

namespace tissue {

/// GSL's own error handler prints and ends the program. Every file that uses GSL includes this one, so that an error there is a status, a NaN or a
/// null pointer that the caller looks at, before main() and in a host that loads the library alike.
inline const bool gsl_errors_are_returned = (gsl_set_error_handler_off(), true);

/// A generator (mt19937) that begins with a seed.
using Rng = std::unique_ptr<gsl_rng, void (*)(gsl_rng*)>;
inline Rng seeded_rng(unsigned long seed) {
    Rng rng(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free);
    if (!rng) throw std::bad_alloc();
    gsl_rng_set(rng.get(), seed);
    return rng;
}

}  // namespace tissue
