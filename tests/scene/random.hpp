#pragma once

#include <cstdint>

#include "tests/frame/random.hpp"

namespace touchable::test {

/// The same numbers on every machine.
class RandomBits {
public:
    explicit RandomBits(std::uint64_t seed) : numbers_(seed) {}

    std::uint64_t bits() { return numbers_.next(); }
    /// 0 to n - 1.
    std::uint64_t below(std::uint64_t n) { return bits() % n; }
    /// With all 53 bits of the mantissa at random.
    double between(double a, double b) { return a + (b - a) * (static_cast<double>(bits() >> 11) * 0x1p-53); }

private:
    Random numbers_;
};

}  // namespace touchable::test
