#pragma once

#include <span>

namespace touchable {

/// What a CPU may have for many values at once; each has what those before it have. `baseline` is what every
/// CPU of its kind has.
enum class VectorUnit { baseline, sse4, avx2, avx512 };

/// Those that this CPU has, the widest first; never empty.
std::span<const VectorUnit> usable_vector_units();

}  // namespace touchable
