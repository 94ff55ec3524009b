#pragma once

#include <cstddef>

namespace touchable::test {

/// Calls of operator new by this thread so far, in this whole program.
std::size_t allocations();

}  // namespace touchable::test
