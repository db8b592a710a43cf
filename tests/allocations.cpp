#include "allocations.h"

#include <Eigen/Core>
#include <cerrno>
#include <cstddef>

namespace {

thread_local bool counting = false;
thread_local long counted = 0, failing = -1;

}  // namespace

#ifndef EIGEN_RUNTIME_NO_MALLOC  // a sanitizer has its own allocator; there Eigen checks (Makefile: ASSERTIONS)
#define TISSUE_SEES_ALLOCATIONS 1
namespace {

/// Counts this allocation. False if it is to fail.
bool allowed() {
    if (!counting) return true;
    if (counted++ != failing) return true;
    errno = ENOMEM;
    return false;
}

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void* malloc(std::size_t size) {
    return allowed() ? __libc_malloc(size) : nullptr;
}
void* calloc(std::size_t count, std::size_t size) {
    return allowed() ? __libc_calloc(count, size) : nullptr;
}
void* realloc(void* memory, std::size_t size) {
    return allowed() ? __libc_realloc(memory, size) : nullptr;
}
void* memalign(std::size_t alignment, std::size_t size) {
    return allowed() ? __libc_memalign(alignment, size) : nullptr;
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    return allowed() ? __libc_memalign(alignment, size) : nullptr;
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
    *memory = allowed() ? __libc_memalign(alignment, size) : nullptr;
    return *memory ? 0 : ENOMEM;
}
}
#endif

namespace tissue {

bool Allocations::seen() {
#ifdef TISSUE_SEES_ALLOCATIONS
    return true;
#else
    return false;
#endif
}

Allocations::Allocations(long fail) {
    counted = 0;
    failing = fail;
    counting = true;
#ifdef EIGEN_RUNTIME_NO_MALLOC
    if (fail < 0) Eigen::internal::set_is_malloc_allowed(false);
#endif
}

Allocations::~Allocations() {
#ifdef EIGEN_RUNTIME_NO_MALLOC
    Eigen::internal::set_is_malloc_allowed(true);
#endif
    counting = false;
    failing = -1;
}

long Allocations::count() {
    return counted;
}

}  // namespace tissue
