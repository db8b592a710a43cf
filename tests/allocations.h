#pragma once

namespace tissue {

/// Counts the allocations of the calling thread. Under a sanitizer, which replaces the allocator, nothing is counted;
/// there Eigen's own check fails an assertion instead (EIGEN_RUNTIME_NO_MALLOC).
class Allocations {
   public:
    static bool seen();      ///< false under a sanitizer

    /// Counts allocations during the lifetime of this object. Allocation number `fail` (from 0) fails; negative: none
    /// fails.
    explicit Allocations(long fail = -1);
    ~Allocations();
    Allocations(const Allocations&) = delete;
    Allocations& operator=(const Allocations&) = delete;

    static long count();     ///< count of the current object, or of the last one
};

}  // namespace tissue
