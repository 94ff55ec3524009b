// SPDX-License-Identifier: Apache-2.0
#include "tests/limits.hpp"

#include <cstdlib>
#include <new>

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define CLANG_COUNTS
#endif
#endif

#ifdef CLANG_COUNTS
// Clang's ThreadSanitizer has operators of its own, next to which no others can be.
#include <sanitizer/allocator_interface.h>

namespace {
thread_local std::size_t count = 0;
const int installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { ++count; }, [](const volatile void*) {});
}  // namespace

void touchable::test::refuse_allocations() {}

std::size_t touchable::test::allocations() {
    return installed > 0 ? count : std::size_t(-1);
}
#else
namespace {
thread_local std::size_t count = 0;
thread_local bool refused = false;
}  // namespace

void touchable::test::refuse_allocations() {
    refused = true;
}

std::size_t touchable::test::allocations() {
    return count;
}

void* operator new(std::size_t size) {
    ++count;
    if (refused) throw std::bad_alloc();
    if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
    throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {  // libraries mix it with plain delete
    ++count;
    return std::malloc(size == 0 ? 1 : size);
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
#endif
