// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_target.hpp"

#include <atomic>
#include <cerrno>
#include <cstdint>

#include "engine/scene/plane_memory.hpp"

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZER_COUNTS
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZER_COUNTS
#endif

namespace {

std::atomic<std::int64_t> live{0}, most_live{0}, allowed{INT64_MAX};

/// Whether so many more bytes may be taken.
bool has_room(std::size_t size) {
    if (live.load(std::memory_order_relaxed) + static_cast<std::int64_t>(size) <=
        allowed.load(std::memory_order_relaxed))
        return true;
    most_live.store(INT64_MAX, std::memory_order_relaxed);
    return false;
}

void add(std::size_t size) {
    const std::int64_t now =
        live.fetch_add(static_cast<std::int64_t>(size)) + static_cast<std::int64_t>(size);
    for (std::int64_t most = most_live.load(); now > most && !most_live.compare_exchange_weak(most, now);) {
    }
}

void take_away(std::size_t size) {
    live.fetch_sub(static_cast<std::int64_t>(size));
}

}  // namespace

#if defined(SANITIZER_COUNTS)

#include <sanitizer/allocator_interface.h>

namespace {
[[maybe_unused]] const int installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t size) {
        (void)has_room(size);
        add(size);
    },
    [](const volatile void* memory) {
        if (memory) take_away(__sanitizer_get_allocated_size(memory));
    });
}  // namespace

#elif defined(__GLIBC__)

#include <malloc.h>

// glibc's own, by the names that it gives those who put others in their place.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}

namespace {

void* counted(void* memory) {
    if (memory) add(malloc_usable_size(memory));
    return memory;
}

void* refused() {
    errno = ENOMEM;
    return nullptr;
}

void* aligned(std::size_t alignment, std::size_t size) {
    return has_room(size) ? counted(__libc_memalign(alignment, size)) : refused();
}

}  // namespace

// Seen by the libraries, too, whose operator new calls them: a GCC that hides names leaves those of glibc's
// headers alone, Clang does not.
#pragma GCC visibility push(default)
extern "C" {
void* malloc(std::size_t size) noexcept {
    return has_room(size) ? counted(__libc_malloc(size)) : refused();
}
void* calloc(std::size_t count, std::size_t size) noexcept {
    std::size_t all = 0;
    if (__builtin_mul_overflow(count, size, &all)) return refused();
    return has_room(all) ? counted(__libc_calloc(count, size)) : refused();
}
void* realloc(void* memory, std::size_t size) noexcept {
    const std::size_t before = memory ? malloc_usable_size(memory) : 0;
    if (size > before && !has_room(size - before)) return refused();
    void* const moved = __libc_realloc(memory, size);
    if (moved || size == 0) take_away(before);
    return counted(moved);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
    return aligned(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
    return aligned(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
    *memory = aligned(alignment, size);
    return *memory ? 0 : ENOMEM;
}
void free(void* memory) noexcept {
    if (memory) take_away(malloc_usable_size(memory));
    __libc_free(memory);
}
}
#pragma GCC visibility pop

#endif

namespace touchable {

bool count_planes(std::int64_t bytes) {
    if (bytes > 0 && !has_room(static_cast<std::size_t>(bytes))) return false;
    if (bytes > 0)
        add(static_cast<std::size_t>(bytes));
    else
        take_away(static_cast<std::size_t>(-bytes));
    return true;
}

}  // namespace touchable

namespace touchable::fuzz {

void count_live_memory(std::size_t most) {
    live = 0;
    most_live = 0;
    allowed = static_cast<std::int64_t>(most);
}

std::size_t most_live_memory() {
    allowed = INT64_MAX;
    return static_cast<std::size_t>(most_live.load());
}

}  // namespace touchable::fuzz
