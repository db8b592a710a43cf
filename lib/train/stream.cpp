#include "train/stream.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace tissue {

Stream::Stream(unsigned long seed, const std::string& purpose, const std::string& set)
    : rng_(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free) {
    const std::string key = fmt::format("{}/{}/{}", seed, purpose, set);
    gsl_rng_set(rng_.get(), XXH3_64bits(key.data(), key.size()) & 0xffffffffUL);  // mt19937 takes 32 bits
}

}  // namespace tissue
