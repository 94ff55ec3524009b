#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "player/audio/heard_sound.hpp"

namespace touchable::test {
namespace {

/// The loudest sample of each of the film's milliseconds; what was not kept is silent.
class Filmed {
public:
    FilmedSound sound{[this](std::int64_t first, std::span<const StereoSample> samples) {
        EXPECT_EQ(first % ContactSound::samples_per_tick, 0);
        EXPECT_GE(first / ContactSound::samples_per_tick, std::ssize(loudest));
        loudest.resize(static_cast<std::size_t>(first / ContactSound::samples_per_tick));
        loudest.push_back(0);
        for (const StereoSample& sample : samples)
            loudest.back() = std::max(loudest.back(), std::abs(sample.left));
    }};
    std::vector<float> loudest;
    ClipSound clip;

    void take(const HeardTick& tick, std::int64_t now_ms, std::int64_t passed = 1) {
        sound.take(tick, passed, clip, now_ms);
    }
};

HeardTick tap() {
    HeardTick tick;
    tick.fingers[0] = {.touching = true, .stiffness = 1000, .met = 0.2F};
    return tick;
}

TEST(FilmedSound, LiesWhereTheFilmIsWhenASessionBegins) {
    Filmed filmed;
    filmed.take({}, 5);
    EXPECT_EQ(filmed.loudest.size(), 6U);
    for (int k = 0; k < 4; ++k) filmed.take({}, 9);  // they come four at a time
    EXPECT_EQ(filmed.loudest.size(), 10U);
    filmed.sound.align();  // 400 ms without a tick
    filmed.take(tap(), 409);
    for (int k = 1; k < 20; ++k) filmed.take({}, 409 + k);
    ASSERT_EQ(filmed.loudest.size(), 429U);
    for (std::size_t k = 0; k < 409; ++k) EXPECT_EQ(filmed.loudest[k], 0) << k;
    EXPECT_GT(filmed.loudest[412], 0.01F);
}

TEST(FilmedSound, FillsTicksThatWereSkippedAndNeverRunsAhead) {
    Filmed filmed;
    filmed.take({}, 100);  // 50 ms late, as it turns out
    for (int k = 51; k < 100; ++k) filmed.take(k == 60 ? tap() : HeardTick{}, k);
    EXPECT_EQ(filmed.loudest.size(), 101U);
    filmed.take({}, 100);
    filmed.take({}, 101);
    for (int k = 102; k < 110; ++k) filmed.take({}, k);
    EXPECT_EQ(filmed.loudest.size(), 110U);
    EXPECT_GT(filmed.loudest[104], 0.01F) << "the tap is lost";
    filmed.take({}, 150, 41);
    EXPECT_EQ(filmed.loudest.size(), 151U);
}

}  // namespace
}  // namespace touchable::test
