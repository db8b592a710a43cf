#pragma once

#include <string>

#include "gsl.h"

namespace tissue {

/// A GSL generator (mt19937) that no other set or purpose shares: what it draws depends on the three and nothing else.
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
