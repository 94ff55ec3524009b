#include "engine/formats/value_evidence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "engine/content/seeded_noise.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr int many = 5000;

/// The nearest float of 11 bits, by a second way: it is the sum that rounds.
float half_of(double value) {
    int exponent = 0;
    std::frexp(value, &exponent);
    return static_cast<float>(std::ldexp(std::nearbyint(std::ldexp(value, 11 - exponent)), exponent - 11));
}

std::optional<FloatLattice> lattice_of(int count, double metres, const std::function<float(int k)>& value) {
    LatticeSearch search;
    for (int k = 0; k < count; ++k) search.add(value(k));
    return search.of_lengths(metres);
}

/// Codes of a scene: what lies before a wall that leans.
std::vector<int> scene_codes(SplitMix64& random, int least, int most, int count = many) {
    std::vector<int> codes;
    for (int k = 0; k < count; ++k) {
        const double share = random.unit(), lean = 0.3 * random.unit();
        codes.push_back(least + static_cast<int>((most - least) * (share < 0.4 ? lean : 1 - lean)));
    }
    return codes;
}

TEST(FloatLattice, MultiplesOfAnyUnitAreFoundHoweverTheyWereMade) {
    SplitMix64 random(1);
    for (int round = 0; round < 300; round += static_cast<int>(sweep_step())) {
        // From 10 um to 1 cm, of any digits; and what people use.
        constexpr double usual[] = {0.001, 0.000125, 0.0001, 1.0 / 5000, 0.00025, 1.0 / 256, 1.0 / 3000};
        const double unit =
            round % 2 == 0 ? usual[(round / 2 + round / 14) % 7] : 1e-5 * std::exp(6.9 * random.unit());
        const int most = 2000 + static_cast<int>(60000 * random.unit()), least = most / 3;
        const auto codes = scene_codes(random, least, most);
        for (const int way : {0, 1, 2}) {
            const auto found = lattice_of(many, 1, [&](int k) {
                const int code = codes[static_cast<std::size_t>(k)];
                if (way == 0) return static_cast<float>(code) * static_cast<float>(unit);
                if (way == 1) return static_cast<float>(code) / static_cast<float>(1 / unit);
                return static_cast<float>(code * unit);
            });
            ASSERT_TRUE(found) << "unit " << unit << " most " << most << " way " << way;
            EXPECT_EQ(found->first, 0) << unit;
            EXPECT_FALSE(found->of_reciprocals) << unit;
            EXPECT_EQ(found->off, 0) << unit;
            EXPECT_NEAR(found->step, unit, 0.2 * unit / most) << "way " << way << " most " << most;
            if (round % 2 == 0) {
                EXPECT_DOUBLE_EQ(found->step, unit);
            }
        }
    }
}

/// The same depths in millimetres, as floats.
TEST(FloatLattice, WholeMillimetresAreOnes) {
    SplitMix64 random(2);
    const auto codes = scene_codes(random, 350, 4000);
    const auto found = lattice_of(
        many, 0.001, [&](int k) { return static_cast<float>(codes[static_cast<std::size_t>(k)]); });
    ASSERT_TRUE(found);
    EXPECT_EQ(found->step, 1);
}

/// A camera that measures disparities and writes millimetres leaves most of these out.
TEST(FloatLattice, LevelsThatAreFarApartAreStillMultiplesOfTheUnit) {
    SplitMix64 random(3);
    const auto found = lattice_of(many, 1, [&](int) {
        const int disparity = 60 + static_cast<int>(200 * random.unit());
        return static_cast<float>(std::floor(75e3 / disparity)) * 0.001F;
    });
    ASSERT_TRUE(found);
    EXPECT_DOUBLE_EQ(found->step, 0.001);
}

TEST(FloatLattice, DisparitiesAreFoundByTheirReciprocals) {
    SplitMix64 random(4);
    for (int round = 0; round < 200; ++round) {
        constexpr double parts[] = {1, 8, 16, 32};
        const double part = parts[round % 4], focal_baseline = 20 + 400 * random.unit();
        const int least = static_cast<int>(part * (12 + 40 * random.unit())), most = 2 * least + 60;
        const auto codes = scene_codes(random, least, most);
        const auto found = lattice_of(many, 1, [&](int k) {
            return static_cast<float>(focal_baseline) /
                   (static_cast<float>(codes[static_cast<std::size_t>(k)]) / static_cast<float>(part));
        });
        ASSERT_TRUE(found) << round;
        EXPECT_TRUE(found->of_reciprocals);
        EXPECT_EQ(found->first, 0);
        const double step = 1 / (part * focal_baseline);
        EXPECT_NEAR(found->step, step, 0.1 * step / most) << round;
    }
}

/// Kinect's formula, and planes of codes evenly in depth and in 1/depth: these do not go through zero.
TEST(FloatLattice, StepsMayBeginAnywhere) {
    SplitMix64 random(5);
    const auto codes = scene_codes(random, 400, 950);
    const auto kinect = lattice_of(many, 1, [&](int k) {
        const double raw = codes[static_cast<std::size_t>(k)];
        return static_cast<float>(1 / (raw * -0.0030711016 + 3.3309495161));
    });
    ASSERT_TRUE(kinect);
    EXPECT_TRUE(kinect->of_reciprocals);
    EXPECT_NEAR(kinect->step, 0.0030711016, 1e-9);
    const double places = (3.3309495161 - kinect->first) / kinect->step;
    EXPECT_NEAR(places, std::round(places), 1e-3);
    const auto linear = lattice_of(many, 1, [&](int k) {
        return static_cast<float>(0.713 + 1.9 * (codes[static_cast<std::size_t>(k)] & 255) / 255);
    });
    ASSERT_TRUE(linear);
    EXPECT_FALSE(linear->of_reciprocals);
    EXPECT_NEAR(linear->step, 1.9 / 255, 1e-8);
}

TEST(FloatLattice, WhatIsOfNoLatticeIsTakenForNone) {
    SplitMix64 random(6);
    for (int round = 0; round < 200; ++round) {
        const double near = 0.2 + 3 * random.unit(), range = 0.01 + 5 * random.unit();
        const int count = round % 4 == 0 ? 9 + round / 4 : many;
        // Noise; a wall that leans; a ball before it.
        const auto found = lattice_of(count, 1, [&](int k) {
            const double share = round % 3 == 0 ? random.unit() : k / static_cast<double>(count);
            if (round % 3 == 2 && k % 2 == 0)
                return static_cast<float>(near + range * (1 - std::sqrt(1 - share * share)));
            return static_cast<float>(near +
                                      range * share * (1 + (round % 3 == 1 ? 0.1 * std::sqrt(share) : 0)));
        });
        EXPECT_FALSE(found) << round << " step " << (found ? found->step : 0) << " of " << count;
    }
}

/// Steps of 10 um over 4 m are more than codes of 16 bits: to know of them helps nobody.
TEST(FloatLattice, OfMoreStepsThanCodesIsTakenForNone) {
    SplitMix64 random(7);
    const auto codes = scene_codes(random, 40'000, 400'000);
    EXPECT_FALSE(lattice_of(
        many, 1, [&](int k) { return static_cast<float>(codes[static_cast<std::size_t>(k)] * 1e-5); }));
}

/// A few walls at whole metres, or anywhere, are not what a sensor rounds to.
TEST(FloatLattice, AFewFlatThingsAreNone) {
    for (const int walls : {1, 3, 7}) {
        EXPECT_FALSE(lattice_of(many, 1, [&](int k) { return static_cast<float>(1 + k % walls); }));
        EXPECT_FALSE(lattice_of(many, 0.001, [&](int k) { return static_cast<float>(1 + k % walls); }));
    }
    EXPECT_FALSE(lattice_of(many, 1, [](int k) { return 0.51713F * static_cast<float>(k % 12) + 0.5F; }));
    EXPECT_FALSE(lattice_of(0, 1, [](int) { return 1.0F; }));
}

TEST(FloatLattice, AFewFloatsMayLieBetweenAndAreCounted) {
    SplitMix64 random(8);
    const auto codes = scene_codes(random, 500, 3000);
    for (const double off : {0.002, 0.008, 0.03, 0.5}) {
        const auto found = lattice_of(many, 1, [&](int k) {
            const double between = random.unit() < off ? 0.2 + 0.6 * random.unit() : 0;
            return static_cast<float>(0.000731 * (codes[static_cast<std::size_t>(k)] + between));
        });
        ASSERT_EQ(found.has_value(), off < 0.01) << off;
        if (!found) continue;
        EXPECT_NEAR(found->step, 0.000731, 1e-8);
        EXPECT_NEAR(found->off, off, 0.004);
    }
}

TEST(FloatLattice, HalvesAreMultiplesOfTheStepAtTheNearest) {
    SplitMix64 random(9);
    const auto found = lattice_of(many, 1, [&](int) { return half_of(0.6 + 3 * random.unit()); });
    ASSERT_TRUE(found);
    EXPECT_EQ(found->step, 0x1p-11);
    EXPECT_FALSE(found->is_rounded);
    EXPECT_EQ(found->off, 0);
}

TEST(FloatLattice, HalvesOfMillimetresAreMillimetres) {
    SplitMix64 random(10);
    const auto codes = scene_codes(random, 450, 3500);
    const auto found = lattice_of(many, 1, [&](int k) {
        return half_of(static_cast<float>(codes[static_cast<std::size_t>(k)]) * 0.001F);
    });
    ASSERT_TRUE(found);
    EXPECT_EQ(found->step, 0.001);
    EXPECT_TRUE(found->is_rounded);
}

TEST(FloatLattice, IsTheSameInAnyOrder) {
    SplitMix64 random(11);
    std::vector<float> values;
    for (const int code : scene_codes(random, 700, 6000))
        values.push_back(static_cast<float>(code * 0.000317));
    LatticeSearch one, other;
    for (const float value : values) one.add(value);
    std::reverse(values.begin(), values.end());
    for (const float value : values) other.add(value);
    const auto a = one.of_lengths(1), b = other.of_lengths(1);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->step, b->step);
    EXPECT_EQ(a->first, b->first);
}

TEST(FloatLattice, NumbersWithoutAUnitMayBeOfAnySteps) {
    SplitMix64 random(12);
    LatticeSearch shares, network;
    for (int k = 0; k < many; ++k) {
        shares.add(static_cast<float>(std::floor(256 * random.unit()) / 255));
        network.add(static_cast<float>(-3 + 20 * random.unit()));
    }
    const auto found = shares.of_numbers();
    ASSERT_TRUE(found);
    EXPECT_DOUBLE_EQ(found->step, 1.0 / 255);
    EXPECT_FALSE(network.of_numbers());
}

}  // namespace
}  // namespace touchable::test
