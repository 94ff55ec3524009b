#include "shaders/median_network.h"

#include <gtest/gtest.h>

#include <algorithm>
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

Bits median_of_numbers3(std::uint64_t n) {
    Bits columns[3][3], pair[4];
    for (int k = 0; k < 9; ++k) columns[k / 3][k % 3] = bit_of_numbers(n, k);
    for (auto& column : columns) sort3(column);
    pair3(columns[0], columns[1], pair);
    return median9(pair, columns[2]);
}

Bits median_of_numbers5(std::uint64_t n) {
    Bits columns[5][5], first[10], second[10], quad[6];
    for (int k = 0; k < 25; ++k) columns[k / 5][k % 5] = bit_of_numbers(n, k);
    for (auto& column : columns) sort5(column);
    pair5(columns[0], columns[1], first);
    pair5(columns[2], columns[3], second);
    quad5(first, second, quad);
    return median25(quad, columns[4]);
}

/// A network of minima and maxima is right for all inputs where it is right for all inputs of zeros and ones.
template <class Median>
void expect_median_of_all_zeros_and_ones(int values, Median&& median_of_numbers) {
    for (std::uint64_t n = 0; n < (std::uint64_t{1} << values) / 64; ++n) {
        std::uint64_t expected = 0;
        for (std::uint64_t lane = 0; lane < 64; ++lane)
            if (std::popcount(64 * n + lane) > values / 2) expected |= std::uint64_t{1} << lane;
        ASSERT_EQ(median_of_numbers(n).word, expected) << "inputs from " << 64 * n;
    }
}

TEST(MedianNetwork, IsRightForEveryWindowOf3x3) {
    expect_median_of_all_zeros_and_ones(9, median_of_numbers3);
}
TEST(MedianNetwork, IsRightForEveryWindowOf5x5) {
    expect_median_of_all_zeros_and_ones(25, median_of_numbers5);
}

/// A window that a row shares with the one above it, as kernels sort their columns.
template <int Side>
void expect_inserting_sorts() {
    for (std::uint64_t n = 0; n < 32; ++n) {
        Bits sorted[Side], inserted[Side];
        for (int k = 0; k < Side; ++k) sorted[k] = inserted[k] = {n >> k & 1};
        if constexpr (Side == 3) {
            sort3(sorted);
            order(inserted[1], inserted[2]);
            insert3(inserted);
        } else {
            sort5(sorted);
            sort4(inserted[1], inserted[2], inserted[3], inserted[4]);
            insert5(inserted);
        }
        for (int k = 0; k < Side; ++k) {
            ASSERT_EQ(sorted[k].word, inserted[k].word);
            ASSERT_LE(sorted[std::max(k - 1, 0)].word, sorted[k].word);
        }
    }
}

TEST(MedianNetwork, SortsColumnsByInsertionToo) {
    expect_inserting_sorts<3>();
    expect_inserting_sorts<5>();
}

}  // namespace
}  // namespace touchable::test
