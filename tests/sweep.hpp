// SPDX-License-Identifier: Apache-2.0
#pragma once

// What goes over many cases: numbers drawn at random, and the places of a long sweep.

#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace touchable::test {

/// splitmix64: the same numbers everywhere, from any seed.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next() {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
        return z ^ (z >> 31);
    }
    /// 0 <= result < n; the bias of the remainder does not matter to a test.
    int below(int n) { return static_cast<int>(next() % static_cast<std::uint64_t>(n)); }
    double within(double least, double most) {
        return least + (most - least) * (static_cast<double>(below(1 << 30)) / (1 << 30));
    }
    /// The same with all 53 bits of the mantissa at random.
    double between(double least, double most) {
        return least + (most - least) * (static_cast<double>(next() >> 11) * 0x1p-53);
    }

private:
    std::uint64_t state_;
};

/// From one place of a long sweep to the next, such as of every byte of a file, or of random cases. 1; or 7,
/// which shares no factor with what repeats in a file, if TOUCHABLE_SHORT_SWEEPS is set. The tests of every
/// change set it; `./run test --all` takes all.
inline std::size_t sweep_step() {
    return std::getenv("TOUCHABLE_SHORT_SWEEPS") != nullptr ? 7 : 1;
}

}  // namespace touchable::test
