#pragma once

#include <string>

#include "gsl.h"

namespace tissue {

/// A GSL random generator (mt19937) seeded by (seed, purpose, set). No other purpose or set shares it, so its numbers
/// do not depend on the order of the trainings. purpose: "weights" or the name of an optimiser; set: name of the case.
class Stream {
   public:
    Stream(unsigned long seed, const std::string& purpose, const std::string& set);
    operator gsl_rng*() const { return rng_.get(); }

    /// Uniform in [range[0], range[1]).
    double uniform(const double (&range)[2]) const { return range[0] + (range[1] - range[0]) * gsl_rng_uniform(*this); }

   private:
    Rng rng_;
};

}  // namespace tissue
