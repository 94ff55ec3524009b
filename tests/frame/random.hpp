#pragma once

#include <cstdint>

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
    double within(double low, double high) {
        return low + (high - low) * (static_cast<double>(below(1 << 30)) / (1 << 30));
    }

private:
    std::uint64_t state_;
};

}  // namespace touchable::test
