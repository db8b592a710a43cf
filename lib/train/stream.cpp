#include "train/stream.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace tissue {
namespace {

// a seed of mt19937 has 32 bits
unsigned long seed_of(const std::string& key) { return XXH3_64bits(key.data(), key.size()) & 0xffffffffUL; }

}  // namespace

Stream::Stream(unsigned long seed, const std::string& purpose, const std::string& set)
    : rng_(seeded_rng(seed_of(fmt::format("{}/{}/{}", seed, purpose, set)))) {}

}  // namespace tissue
