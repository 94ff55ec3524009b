#pragma once

#include <cstddef>
#include <cstdlib>

namespace touchable::test {

/// From one place of a long sweep to the next, such as of every byte of a file, or of random cases. 1; or 7,
/// which shares no factor with what repeats in a file, if TOUCHABLE_SHORT_SWEEPS is set. The tests of every
/// change set it; `./run test --all` takes all.
inline std::size_t sweep_step() {
    return std::getenv("TOUCHABLE_SHORT_SWEEPS") != nullptr ? 7 : 1;
}

}  // namespace touchable::test
