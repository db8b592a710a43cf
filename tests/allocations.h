#pragma once

namespace tissue {

/// A hook under every allocation of this program, for the calling thread. Under a sanitizer, which has hooks of its own,
/// it sees nothing; there Eigen's own check stands in for it (EIGEN_RUNTIME_NO_MALLOC, a failed assertion).
class Allocations {
   public:
    static bool seen();      ///< false under a sanitizer

    /// From here to the end of this object's life allocations are counted, and number `fail` of them (from 0) fails.
    explicit Allocations(long fail = -1);
    ~Allocations();
    Allocations(const Allocations&) = delete;
    Allocations& operator=(const Allocations&) = delete;

    static long count();     ///< of the object that lives, or lived last
};

}  // namespace tissue
