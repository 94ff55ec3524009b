#pragma once

#include <cstddef>

namespace touchable::fuzz {

/// Bytes of the heap and of planes that this program holds, its libraries and all its threads included. Bytes
/// of files that are mapped do not count.
///
/// Begins anew: what is there already is none of it. More than `most` at a time are refused where this
/// program's own malloc counts (glibc's), which is no memory for the caller; sanitizers' only count.
void count_live_memory(std::size_t most);
/// The most that were there at a time since then.
std::size_t most_live_memory();

}  // namespace touchable::fuzz
