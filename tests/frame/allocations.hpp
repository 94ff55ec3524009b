#pragma once

#include <cstddef>

namespace touchable::test {

/// Calls of operator new by this thread so far, in this whole program.
std::size_t allocations();
/// From here on each of them by this thread throws, as where memory is gone; under Clang's ThreadSanitizer
/// none does.
void refuse_allocations();

}  // namespace touchable::test
