// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "engine/base/same_bits.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

/// Distance from the truth in units of the last place of the truth rounded to double.
double ulps(double value, long double truth) {
    int exponent = 0;
    std::frexp(static_cast<double>(truth), &exponent);
    const double ulp = std::ldexp(1.0, std::max(exponent - 53, -1074));
    return static_cast<double>(std::fabs(static_cast<long double>(value) - truth) /
                               static_cast<long double>(ulp));
}

double worst_of_sine_and_cosine(double x) {
    return std::max(ulps(sine(x), std::sin(static_cast<long double>(x))),
                    ulps(cosine(x), std::cos(static_cast<long double>(x))));
}

/// A number of random size as well as digits.
double of_any_size(Random& random, int least_exponent, int most_exponent) {
    const int exponent = least_exponent + random.below(most_exponent - least_exponent);
    const double magnitude = std::ldexp(random.between(1.0, 2.0), exponent);
    return random.below(2) ? magnitude : -magnitude;
}

TEST(Trigonometry, BoundsSineErrorToMillion) {
    Random random(1);
    double worst = 0;
    for (int k = 0; k < 200000; ++k) {
        worst = std::max(worst, worst_of_sine_and_cosine(random.between(-1e6, 1e6)));
        worst = std::max(worst, worst_of_sine_and_cosine(random.between(-8.0, 8.0)));
        worst = std::max(worst, worst_of_sine_and_cosine(of_any_size(random, -60, 20)));
    }
    EXPECT_LE(worst, 2.0);
}

TEST(Trigonometry, BoundsSineErrorNearMultiples) {
    constexpr long double half_pi = 1.57079632679489661923132169163975144L;
    double worst = 0;
    for (int k = 1; k <= 636619; ++k) {
        const auto nearest = static_cast<double>(static_cast<long double>(k) * half_pi);
        for (const double x : {std::nextafter(nearest, 0.0), nearest, std::nextafter(nearest, inf)})
            worst = std::max(worst, worst_of_sine_and_cosine(x));
    }
    EXPECT_LE(worst, 2.0);
}

TEST(Trigonometry, BoundsSineErrorBetweenQuarters) {
    Random random(2);
    double worst = 0;
    for (int k = 0; k < 100000; ++k) {
        const double turns = static_cast<double>(random.below(636619)) + 0.5;
        const double x = turns * (pi / 2) * (1 + random.between(-1e-15, 1e-15));
        worst = std::max(worst, worst_of_sine_and_cosine(x));
    }
    EXPECT_LE(worst, 2.0);
}

TEST(Trigonometry, BoundsArctangentError) {
    Random random(3);
    double worst = 0;
    const auto check = [&](double x) {
        worst = std::max(worst, ulps(arctangent(x), std::atan(static_cast<long double>(x))));
    };
    for (int k = 0; k < 200000; ++k) {
        check(random.between(-1.5, 1.5));
        check(of_any_size(random, -300, 300));
        const double eighth = static_cast<double>(random.below(9)) / 8;  // where the table changes
        check(eighth + random.between(-1e-10, 1e-10));
    }
    EXPECT_LE(worst, 2.0);
    EXPECT_DOUBLE_EQ(arctangent(inf), pi / 2);
    EXPECT_DOUBLE_EQ(arctangent(-inf), -pi / 2);
}

TEST(Trigonometry, BoundsArctangent2ErrorInQuadrants) {
    Random random(4);
    double worst = 0;
    const auto check = [&](double y, double x) {
        worst = std::max(worst, ulps(arctangent2(y, x),
                                     std::atan2(static_cast<long double>(y), static_cast<long double>(x))));
    };
    for (int k = 0; k < 300000; ++k) {
        check(random.between(-1, 1), random.between(-1, 1));
        check(of_any_size(random, -40, 40), of_any_size(random, -40, 40));
    }
    EXPECT_LE(worst, 2.0);
}

TEST(Trigonometry, DefinesArctangent2OnAxes) {
    EXPECT_EQ(arctangent2(0, 0), 0.0);
    EXPECT_EQ(arctangent2(0, 1), 0.0);
    EXPECT_EQ(arctangent2(1, 0), pi / 2);
    EXPECT_EQ(arctangent2(0, -1), pi);
    EXPECT_EQ(arctangent2(-0.0, -1), pi);  // (-pi, pi]
    EXPECT_EQ(arctangent2(-1, 0), -pi / 2);
    EXPECT_EQ(arctangent2(1, 1), pi / 4);
    EXPECT_EQ(arctangent2(inf, inf), pi / 4);
    EXPECT_EQ(arctangent2(1, inf), 0.0);
    EXPECT_EQ(arctangent2(-1, -inf), -pi);
}

TEST(Trigonometry, BoundsArcsineError) {
    Random random(5);
    double worst = 0;
    const auto check = [&](double x) {
        worst = std::max(worst, ulps(arcsine(x), std::asin(static_cast<long double>(x))));
    };
    for (int k = 0; k < 300000; ++k) {
        check(random.between(-1, 1));
        check(of_any_size(random, -60, 0));
        check(1.0 - std::fabs(of_any_size(random, -54, -1)));
        check(0.5 + random.between(-1e-12, 1e-12));
    }
    EXPECT_LE(worst, 2.0);
}

TEST(Trigonometry, ClampsArcsineBeyondOne) {
    EXPECT_EQ(arcsine(1.0), pi / 2);
    EXPECT_EQ(arcsine(1.5), pi / 2);
    EXPECT_EQ(arcsine(-1.5), -pi / 2);
    EXPECT_EQ(arcsine(inf), pi / 2);
}

TEST(Trigonometry, HasExactSymmetries) {
    Random random(6);
    for (int k = 0; k < 20000; ++k) {
        const double x = of_any_size(random, -60, 20), y = random.between(-1, 1);
        ASSERT_EQ(sine(-x), -sine(x)) << x;
        ASSERT_EQ(cosine(-x), cosine(x)) << x;
        ASSERT_EQ(arctangent(-x), -arctangent(x)) << x;
        ASSERT_EQ(arcsine(-y), -arcsine(y)) << y;
    }
}

TEST(Trigonometry, StaysBoundedForHugeArguments) {
    Random random(7);
    for (int k = 0; k < 20000; ++k) {
        const double x = of_any_size(random, 20, 1023);
        ASSERT_LE(std::fabs(sine(x)), 1.0) << x;
        ASSERT_LE(std::fabs(cosine(x)), 1.0) << x;
    }
}

TEST(Trigonometry, KeepsNotANumber) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double value : {sine(nan), cosine(nan), sine(inf), cosine(-inf), arctangent(nan),
                               arctangent2(nan, 1), arctangent2(1, nan), arcsine(nan)})
        EXPECT_TRUE(std::isnan(value));
}

// The promise for which these functions exist: compilers, optimisation levels and CPUs agree with this
// number.
TEST(Trigonometry, GivesSameBitsEverywhere) {
    Random random(8);
    std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a over the results' bits
    const auto take = [&](double value) {
        hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3u;
    };
    for (int k = 0; k < 100000; ++k) {
        const double x = of_any_size(random, -20, 20), y = of_any_size(random, -20, 20);
        take(sine(x));
        take(cosine(x));
        take(arctangent(x));
        take(arctangent2(y, x));
        take(arcsine(x));
    }
    EXPECT_EQ(hash, 11369820731776881405u);
}

TEST(Exponential, StaysWithinOneUlp) {
    Random random(31);
    double worst = 0;
    const auto check = [&](double x) {
        worst = std::max(worst, ulps(exponential(x), std::exp(static_cast<long double>(x))));
    };
    for (int k = 0; k < 200000; ++k) {
        check(random.between(-708, 709.7));
        check(random.between(-3, 3));
        check(std::ldexp(random.between(-1, 1), -random.below(70)));
        // Near changes of the power of two.
        check((static_cast<double>(random.below(2000)) - 1000 + 0.5) * 0.6931471805599453 *
              (1 + random.between(-1e-15, 1e-15)) * 0.7);
    }
    EXPECT_LE(worst, 1.0);
}

TEST(Exponential, EndsWhereDoublesDo) {
    EXPECT_EQ(exponential(0), 1);
    EXPECT_EQ(exponential(-0.0), 1);
    EXPECT_EQ(exponential(709.8), inf);
    EXPECT_EQ(exponential(inf), inf);
    EXPECT_EQ(exponential(-inf), 0);
    EXPECT_EQ(exponential(-746), 0);
    EXPECT_GT(exponential(-745), 0);
    EXPECT_TRUE(std::isnan(exponential(std::nan(""))));
}

TEST(Logarithm, StaysWithinOneUlp) {
    Random random(32);
    double worst = 0;
    const auto check = [&](double x) {
        worst = std::max(worst, ulps(logarithm(x), std::log(static_cast<long double>(x))));
    };
    for (int k = 0; k < 200000; ++k) {
        check(random.between(0.25, 4));
        check(1 + std::ldexp(random.between(-1, 1), -1 - random.below(52)));
        check(std::ldexp(random.between(1, 2), random.below(2090) - 1070));
        check(0.7071067811865476 * (1 + random.between(-1e-15, 1e-15)));
    }
    EXPECT_LE(worst, 1.0);
}

TEST(Logarithm, EndsWhereDoublesDo) {
    EXPECT_EQ(logarithm(1), 0);
    EXPECT_EQ(logarithm(0), -inf);
    EXPECT_EQ(logarithm(inf), inf);
    EXPECT_TRUE(std::isnan(logarithm(-1)));
    EXPECT_TRUE(std::isnan(logarithm(std::nan(""))));
}

/// The hash was taken on one machine; a machine with other bits fails.
TEST(Logarithm, GivesSameBitsEverywhere) {
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
}  // namespace touchable::test
