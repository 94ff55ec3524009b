#include "engine/surface/median_network.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>

namespace touchable::test {
namespace {

/// 64 inputs of zeros and ones at once: the lesser of two bits is their and, the greater their or.
struct Bits {
    std::uint64_t word = 0;
};
Bits lesser(Bits a, Bits b) {
    return {a.word & b.word};
}
Bits greater(Bits a, Bits b) {
    return {a.word | b.word};
}

/// Bit k of the number 64 n + lane, for all lanes.
Bits bit_of_numbers(std::uint64_t n, int k) {
    static constexpr std::uint64_t lanes[6] = {0xAAAAAAAAAAAAAAAA, 0xCCCCCCCCCCCCCCCC, 0xF0F0F0F0F0F0F0F0,
                                               0xFF00FF00FF00FF00, 0xFFFF0000FFFF0000, 0xFFFFFFFF00000000};
    if (k < 6) return {lanes[k]};
    return {(n >> (k - 6)) & 1 ? ~std::uint64_t{0} : 0};
}

template <int Side>
std::uint64_t median_of_numbers(std::uint64_t n) {
    Bits ranks[Side][Side];
    for (int column = 0; column < Side; ++column) {
        Bits values[Side];
        for (int k = 0; k < Side; ++k) values[k] = bit_of_numbers(n, column * Side + k);
        sort_column(values);
        for (int k = 0; k < Side; ++k) ranks[k][column] = values[k];
    }
    return median_of_sorted_columns(ranks).word;
}

/// A network of minima and maxima is right for all inputs where it is right for all inputs of zeros and ones.
template <int Side>
void expect_median_of_all_zeros_and_ones() {
    constexpr int values = Side * Side;
    for (std::uint64_t n = 0; n < (std::uint64_t{1} << values) / 64; ++n) {
        std::uint64_t expected = 0;
        for (std::uint64_t lane = 0; lane < 64; ++lane)
            if (std::popcount(64 * n + lane) > values / 2) expected |= std::uint64_t{1} << lane;
        ASSERT_EQ(median_of_numbers<Side>(n), expected) << "inputs from " << 64 * n;
    }
}

TEST(MedianNetwork, IsRightForEveryWindowOf3x3) {
    expect_median_of_all_zeros_and_ones<3>();
}
TEST(MedianNetwork, IsRightForEveryWindowOf5x5) {
    expect_median_of_all_zeros_and_ones<5>();
}

}  // namespace
}  // namespace touchable::test
