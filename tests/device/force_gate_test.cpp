// SPDX-License-Identifier: Apache-2.0
// The gate that each force passes on its way to a device, against a twin that decides slowly and obviously,
// on every combination of the values at which a comparison of doubles may go wrong, and on random bits.
// (tests/proof/ proves the promises for all values; here the code runs that the compiler made.)
#include "device/force_gate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace touchable::test {
namespace {

using Limits = std::numeric_limits<double>;
using Force = std::array<double, 3>;

constexpr double quiet_nan = Limits::quiet_NaN(), endless = Limits::infinity();

double below(double value) {
    return std::nextafter(value, -endless);
}
double above(double value) {
    return std::nextafter(value, endless);
}

/// Long double has 11 bits more than a double, and exponents for the square of each.
long double squared_length(const Force& force) {
    static_assert(std::numeric_limits<long double>::digits >= 64);
    long double sum = 0;
    for (const double one : force) sum += static_cast<long double>(one) * one;
    return sum;
}

double expected_ceiling(double ceiling, double limit, double ramp) {
    const double risen = ceiling + ramp;
    if (std::isnan(risen) || std::isnan(limit)) return 0;
    const double least = std::min(risen, limit);
    return least >= 0 && least <= 1e9 ? least : 0;
}

bool same_bits(const Force& a, const Force& b) {
    return std::bit_cast<std::array<std::uint64_t, 3>>(a) == std::bit_cast<std::array<std::uint64_t, 3>>(b);
}

/// The fault of a result; nullptr: none. Squares of doubles below 1e-150 underflow: there only the bounds
/// count.
const char* fault_of(const Force& in, double ceiling, double limit, double ramp) {
    Force out = in;
    const double most = force_gate(out.data(), ceiling, limit, ramp);
    if (most != expected_ceiling(ceiling, limit, ramp)) return "the ceiling is another";
    for (const double one : out)
        if (!(std::abs(one) <= most)) return "a component is beyond the ceiling";
    const long double top = static_cast<long double>(most) * most, square = squared_length(out);
    if (!(square <= top * (1 + 0x1p-50L) + 1e-320L)) return "the force is longer than the ceiling";

    const bool is_finite = std::isfinite(in[0]) && std::isfinite(in[1]) && std::isfinite(in[2]);
    if (!is_finite) return square == 0 ? nullptr : "a value that is not finite gives a force";
    const long double asked = squared_length(in);
    if (asked <= top * (1 - 0x1p-50L) && most > 1e-150) {
        return same_bits(in, out) ? nullptr : "a force within the ceiling is changed";
    }
    if (asked < top * (1 + 0x1p-50L) || most < 1e-150 || asked > 1e300L) return nullptr;
    if (!(square >= top * (1 - 0x1p-46L))) return "a long force is shortened too much";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const long double along = in[axis] * std::sqrt(top / asked);
        if (!(std::abs(out[axis] - along) <= most * 0x1p-46L)) return "a long force has another direction";
    }
    return nullptr;
}

void expect_sound(const Force& in, double ceiling, double limit, double ramp) {
    const char* fault = fault_of(in, ceiling, limit, ramp);
    ASSERT_EQ(fault, nullptr) << fault << std::hexfloat << ": force " << in[0] << ' ' << in[1] << ' ' << in[2]
                              << ", ceiling " << ceiling << ", limit " << limit << ", ramp " << ramp;
}

/// Both signs of each class of doubles and of the borders between them, and of what borders on `bounds`.
std::vector<double> borders(std::initializer_list<double> bounds) {
    std::vector<double> values{0,
                               Limits::denorm_min(),
                               3e-324,
                               below(Limits::min()),
                               Limits::min(),
                               1e-170,
                               1e-162,
                               1e-154,
                               above(Limits::min()),
                               1,
                               1e9,
                               above(1e9),
                               1e154,
                               above(std::sqrt(Limits::max())),
                               1e200,
                               below(Limits::max()),
                               Limits::max(),
                               endless,
                               quiet_nan};
    for (const double bound : bounds)
        for (const double part : {1.0, std::sqrt(0.5), std::sqrt(1.0 / 3)})
            values.insert(values.end(), {below(bound * part), bound * part, above(bound * part)});
    for (std::size_t count = values.size(), k = 0; k < count; ++k) values.push_back(-values[k]);
    return values;
}

TEST(ForceGate, ShortensOnlyLongForces) {
    Force force{3, -2, 1};
    EXPECT_EQ(force_gate(force.data(), 8, 8, 0), 8);
    EXPECT_EQ(force, (Force{3, -2, 1}));
    force = {0, 0, -8};
    force_gate(force.data(), 8, 8, 0);
    EXPECT_EQ(force, (Force{0, 0, -8})) << "as long as the limit";
    force = {30, 0, -40};
    EXPECT_EQ(force_gate(force.data(), 10, 10, 0), 10);
    EXPECT_NEAR(force[0], 6, 1e-13);
    EXPECT_NEAR(force[2], -8, 1e-13);
    EXPECT_EQ(force_gate(force.data(), 0.5, 10, 0.25), 0.75);
    EXPECT_NEAR(force[0], 0.45, 1e-14);
    EXPECT_NEAR(force[2], -0.6, 1e-14);
}

TEST(ForceGate, InvalidValuesGiveZeroForce) {
    for (const double bad : {quiet_nan, -quiet_nan, endless, -endless})
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Force force{1, 1, 1};
            force[axis] = bad;
            EXPECT_EQ(force_gate(force.data(), 8, 8, 0), 8);
            EXPECT_EQ(force, Force{}) << bad;
        }
    for (const std::array<double, 3>& bad : {Force{quiet_nan, 8, 1},
                                             {1, quiet_nan, 1},
                                             {1, 8, quiet_nan},
                                             {endless, endless, 1},
                                             {8, -8, 1},
                                             {1, 8, -2}}) {
        Force force{1, 1, 1};
        EXPECT_EQ(force_gate(force.data(), bad[0], bad[1], bad[2]), 0);
        EXPECT_EQ(force, Force{});
    }
}

TEST(ForceGate, HoldsAtBoundaryForces) {
    for (const double limit : {8.0, 0.1, 1e9, 1e-160, Limits::denorm_min()}) {
        const std::vector<double> values = borders({limit});
        for (const double x : values)
            for (const double y : values)
                for (const double z : values)
                    ASSERT_NO_FATAL_FAILURE(expect_sound({x, y, z}, limit, limit, 0));
    }
}

TEST(ForceGate, HoldsAtBoundaryCeilings) {
    const std::vector<double> values = borders({8, 0.08, 7.92});
    for (const double ceiling : values)
        for (const double limit : values)
            for (const double ramp : values) {
                const double most = expected_ceiling(ceiling, limit, ramp);
                for (const double x : {below(most), most, above(most), -most, 3.0, quiet_nan})
                    for (const double y : {0.0, 5.0})
                        ASSERT_NO_FATAL_FAILURE(expect_sound({x, y, 0}, ceiling, limit, ramp));
            }
}

TEST(ForceGate, HoldsForRandomBits) {
    std::mt19937_64 random(7);
    // Half of them any bits, half of them near to each other, where the answer is not plain.
    const auto any = [&] { return std::bit_cast<double>(random()); };
    const auto near = [&](double bound) {
        return bound * (static_cast<double>(random() >> 11) * 0x1p-52 - 1) * (random() % 8 == 0 ? 2 : 0.6);
    };
    for (int k = 0; k < 2'000'000; ++k) {
        if (k % 2 == 0)
            ASSERT_NO_FATAL_FAILURE(expect_sound({any(), any(), any()}, any(), any(), any()));
        else
            ASSERT_NO_FATAL_FAILURE(
                expect_sound({near(8), near(8), near(8)}, std::abs(near(8)), 8, std::abs(near(0.1))));
    }
}

/// For any request: after n calls no force is longer than n ramps, and none is ever beyond the limit.
TEST(ForceGate, CeilingRisesByRamp) {
    std::mt19937_64 random(11);
    constexpr double limit = 8, ramp = 0.08;
    double ceiling = 0;
    for (int calls = 1; calls <= 300; ++calls) {
        Force force{random() % 3 == 0 ? std::bit_cast<double>(random()) : 100, 100, -100};
        const double before = ceiling;
        ceiling = force_gate(force.data(), ceiling, limit, ramp);
        ASSERT_LE(ceiling, before + ramp);
        ASSERT_LE(std::sqrt(squared_length(force)), std::min(limit, calls * ramp) * (1 + 1e-13L));
        ASSERT_GE(ceiling, std::min(limit, calls * ramp) * (1 - 1e-13)) << "it does rise";
    }
    EXPECT_EQ(ceiling, limit);
}

}  // namespace
}  // namespace touchable::test
