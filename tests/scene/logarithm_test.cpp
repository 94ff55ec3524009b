#include "engine/base/same_bits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "tests/scene/random.hpp"

namespace touchable {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

/// Distance from the truth in units of the last place of the truth rounded to double.
double places_off(double value, long double truth) {
    int exponent = 0;
    std::frexp(static_cast<double>(truth), &exponent);
    const double ulp = std::ldexp(1.0, std::max(exponent - 53, -1074));
    return static_cast<double>(std::fabs(static_cast<long double>(value) - truth) /
                               static_cast<long double>(ulp));
}

TEST(Exponential, WithinOneUlpWhereverADoubleIsNormal) {
    Random random(31);
    double worst = 0;
    const auto check = [&](double x) {
        worst = std::max(worst, places_off(exponential(x), std::exp(static_cast<long double>(x))));
    };
    for (int k = 0; k < 200000; ++k) {
        check(random.between(-708, 709.7));
        check(random.between(-3, 3));
        check(std::ldexp(random.between(-1, 1), -static_cast<int>(random.below(70))));
        // Where the power of two changes.
        check((static_cast<double>(random.below(2000)) - 1000 + 0.5) * 0.6931471805599453 *
              (1 + random.between(-1e-15, 1e-15)) * 0.7);
    }
    EXPECT_LE(worst, 1.0);
}

TEST(Exponential, EndsWhereDoublesDo) {
    EXPECT_EQ(exponential(0), 1);
    EXPECT_EQ(exponential(-0.0), 1);
    EXPECT_EQ(exponential(709.8), endless);
    EXPECT_EQ(exponential(endless), endless);
    EXPECT_EQ(exponential(-endless), 0);
    EXPECT_EQ(exponential(-746), 0);
    EXPECT_GT(exponential(-745), 0);
    EXPECT_TRUE(std::isnan(exponential(std::nan(""))));
}

TEST(Logarithm, WithinOneUlpOfAnySize) {
    Random random(32);
    double worst = 0;
    const auto check = [&](double x) {
        worst = std::max(worst, places_off(logarithm(x), std::log(static_cast<long double>(x))));
    };
    for (int k = 0; k < 200000; ++k) {
        check(random.between(0.25, 4));
        check(1 + std::ldexp(random.between(-1, 1), -1 - static_cast<int>(random.below(52))));
        check(std::ldexp(random.between(1, 2), static_cast<int>(random.below(2090)) - 1070));
        check(0.7071067811865476 * (1 + random.between(-1e-15, 1e-15)));
    }
    EXPECT_LE(worst, 1.0);
}

TEST(Logarithm, EndsWhereDoublesDo) {
    EXPECT_EQ(logarithm(1), 0);
    EXPECT_EQ(logarithm(0), -endless);
    EXPECT_EQ(logarithm(endless), endless);
    EXPECT_TRUE(std::isnan(logarithm(-1)));
    EXPECT_TRUE(std::isnan(logarithm(std::nan(""))));
}

/// Of one machine's bits, so that any other that gives other ones is found.
TEST(Logarithm, HasTheSameBitsEverywhere) {
    std::uint64_t hash = 0;
    Random random(33);
    for (int k = 0; k < 100000; ++k) {
        hash =
            hash * 0x9e3779b97f4a7c15U + std::bit_cast<std::uint64_t>(logarithm(random.between(0.001, 100)));
        hash = hash * 0x9e3779b97f4a7c15U + std::bit_cast<std::uint64_t>(exponential(random.between(-9, 9)));
    }
    EXPECT_EQ(hash, 15684742880053105677U);
}

}  // namespace
}  // namespace touchable
