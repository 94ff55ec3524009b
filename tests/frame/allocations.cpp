#include "tests/frame/allocations.hpp"

#include <cstdlib>
#include <new>

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
