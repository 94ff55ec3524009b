// SPDX-License-Identifier: Apache-2.0
// The sound of ticks, sample by sample, and on their way to the loudspeakers.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "player/audio/contact_sound.hpp"
#include "player/audio/heard_sound.hpp"
#include "player/audio/window_sound.hpp"
#include "tests/limits.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

HeardTick tick_of(const HeardFinger& finger) {
    HeardTick tick;
    tick.fingers[0] = finger;
    return tick;
}

HeardFinger sliding(float newtons, float slip, float change = 0) {
    return {.touching = true, .newtons = newtons, .slip = slip, .change = change, .stiffness = 1000};
}

HeardFinger meeting(float speed, float stiffness = 1000) {
    return {.touching = true, .newtons = 0.1F, .stiffness = stiffness, .met = speed};
}

using Sound = std::vector<StereoSample>;

Sound& add(Sound& sound, ContactSound& from, const HeardTick& tick, int ticks) {
    ContactSound::Samples samples{};
    for (int k = 0; k < ticks; ++k) {
        from.render(tick, samples);
        sound.insert(sound.end(), samples.begin(), samples.end());
    }
    return sound;
}

/// `first` for one tick, and `then` for `ticks`.
Sound sound_of(const HeardTick& first, const HeardTick& then, int ticks) {
    ContactSound sound;
    Sound samples;
    add(samples, sound, first, 1);
    return add(samples, sound, then, ticks);
}

Sound sound_of(const HeardFinger& finger, int ticks = 300) {
    return sound_of(tick_of(finger), tick_of(finger), ticks);
}

double loudness(const Sound& sound) {
    double sum = 0;
    for (const StereoSample& sample : sound) sum += sample.left * sample.left + sample.right * sample.right;
    return std::sqrt(sum / static_cast<double>(2 * sound.size()));
}

/// Hertz, by how often the sound crosses zero.
double pitch(const Sound& sound) {
    int crossings = 0;
    for (std::size_t k = 1; k < sound.size(); ++k) crossings += sound[k].left * sound[k - 1].left < 0;
    return 0.5 * crossings * ContactSound::rate / static_cast<double>(sound.size());
}

double largest(const Sound& sound) {
    double most = 0;
    for (const StereoSample& sample : sound)
        most = std::max({most, std::abs(double{sample.left}), std::abs(double{sample.right})});
    return most;
}

double largest_step(const Sound& sound) {
    double most = 0;
    for (std::size_t k = 1; k < sound.size(); ++k)
        most = std::max({most, std::abs(double{sound[k].left} - sound[k - 1].left),
                         std::abs(double{sound[k].right} - sound[k - 1].right)});
    return most;
}

TEST(ContactSound, IsSilentWithoutSliding) {
    EXPECT_EQ(largest(sound_of(HeardFinger{})), 0);
    EXPECT_EQ(largest(sound_of(sliding(5, 0))), 0);
    // A finger off the surface is silent.
    HeardFinger free = sliding(5, 0.2F, 0.1F);
    free.touching = false;
    EXPECT_EQ(largest(sound_of(free)), 0);
}

TEST(ContactSound, ContactTapsAndFades) {
    const Sound tap = sound_of(tick_of(meeting(0.05F)), tick_of(sliding(1, 0)), 600);
    const auto at_ms = [](int ms) { return ms * ContactSound::samples_per_tick; };
    EXPECT_GT(largest({tap.begin(), tap.begin() + at_ms(10)}), 0.05);
    EXPECT_EQ(largest({tap.end() - at_ms(100), tap.end()}), 0);
    EXPECT_GT(loudness(sound_of(tick_of(meeting(0.3F)), {}, 100)),
              1.5 * loudness(Sound(tap.begin(), tap.begin() + at_ms(101))));
    EXPECT_LT(largest_step(tap), 0.03);
}

TEST(ContactSound, StifferStuffRingsHigher) {
    const double soft = pitch(sound_of(tick_of(meeting(0.1F, 400)), {}, 60));
    const double hard = pitch(sound_of(tick_of(meeting(0.1F, 4 * 400)), {}, 60));
    EXPECT_NEAR(hard / soft, 2, 0.2);
}

TEST(ContactSound, LoudnessFollowsForceSpeedRoughness) {
    const double soft = loudness(sound_of(sliding(0.5F, 0.02F)));
    const double pressed = loudness(sound_of(sliding(2, 0.02F)));
    const double fast = loudness(sound_of(sliding(2, 0.1F)));
    const double rough = loudness(sound_of(sliding(2, 0.1F, 0.05F)));
    EXPECT_GT(soft, 0.001);
    EXPECT_GT(pressed, 1.3 * soft);
    EXPECT_GT(fast, 1.3 * pressed);
    EXPECT_GT(rough, 1.3 * fast);
}

TEST(ContactSound, FasterSlidingIsHigher) {
    EXPECT_GT(pitch(sound_of(sliding(2, 0.2F))), 1.5 * pitch(sound_of(sliding(2, 0.02F))));
}

TEST(ContactSound, LettingGoIsAKnock) {
    HeardFinger slips = sliding(3, 0);
    slips.let_go = 0.3F;
    const Sound knock = sound_of(tick_of(slips), tick_of(sliding(3, 0)), 100);
    EXPECT_GT(largest(knock), 0.05);
    EXPECT_EQ(largest({knock.end() - 480, knock.end()}), 0);
}

TEST(ContactSound, PansWithFinger) {
    HeardFinger right = sliding(2, 0.1F);
    right.side = 1;
    double left_sum = 0, right_sum = 0;
    for (const StereoSample& sample : sound_of(right)) {
        left_sum += std::abs(sample.left);
        right_sum += std::abs(sample.right);
    }
    EXPECT_GT(right_sum, 1.5 * left_sum);
    EXPECT_GT(left_sum, 0);
}

TEST(ContactSound, StartsAndEndsWithoutClicks) {
    // Where a slide ends at once, or is muted, the sound ends with steps that are no larger than before.
    for (const bool muted : {false, true}) {
        ContactSound sound;
        Sound samples;
        const double before = largest_step(add(samples, sound, tick_of(sliding(4, 0.3F, 0.1F)), 300));
        EXPECT_LT(before, 0.3);
        HeardTick then = muted ? tick_of(sliding(4, 0.3F, 0.1F)) : HeardTick();
        then.muted = muted;
        Sound after;
        after.push_back(samples.back());
        EXPECT_LE(largest_step(add(after, sound, then, 300)), before);
        EXPECT_EQ(largest({after.end() - 480, after.end()}), 0);
    }
}

TEST(ContactSound, StaysFiniteAndLimited) {
    std::mt19937 random(15);
    ContactSound sound;
    ContactSound::Samples samples{};
    const auto any = [&random] { return std::bit_cast<float>(static_cast<std::uint32_t>(random())); };
    float most = 0;
    bool finite = true;
    const auto hear = [&](const HeardTick& tick) {
        sound.render(tick, samples);
        for (const StereoSample& sample : samples) {
            finite &= std::isfinite(sample.left) && std::isfinite(sample.right);
            most = std::max({most, std::abs(sample.left), std::abs(sample.right)});
        }
    };
    for (int k = 0; k < 300; ++k) {
        HeardTick tick;
        for (HeardFinger& finger : tick.fingers)
            finger = {random() % 2 == 0, any(), any(), any(), any(), any(), any(), any()};
        hear(tick);
    }
    HeardTick loudest;
    loudest.fingers.fill({true, 1e9F, 1e9F, 1e9F, 1e9F, 1e9F, 1e9F, 0});
    for (int k = 0; k < 100; ++k) hear(loudest);
    EXPECT_TRUE(finite);
    EXPECT_LE(most, ContactSound::loudest);
    EXPECT_GT(most, 0.8F * ContactSound::loudest);
    // And it is as before once that is over.
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    HeardTick nothing;
    nothing.fingers.fill({true, none, none, none, none, none, none, none});
    for (int k = 0; k < 600; ++k) hear(nothing);
    most = 0;
    hear(nothing);
    EXPECT_EQ(most, 0);
}

TEST(ContactSound, AllocatesNothing) {
    ContactSound sound;
    HeardTicks ticks(std::make_shared<ClipSound>());
    ContactSound::Samples samples{};
    const std::size_t before = allocations();
    sound.render(tick_of(meeting(0.1F)), samples);
    sound.render(tick_of(sliding(1, 0.1F)), samples);
    ticks.push(tick_of(meeting(0.1F)));
    ticks.fill(samples);
    EXPECT_EQ(allocations(), before);
}

/// The samples of `blocks` blocks of ten milliseconds.
Sound filled(HeardTicks& ticks, int blocks) {
    Sound sound;
    for (int k = 0; k < blocks; ++k) {
        Sound block(480);
        ticks.fill(block);
        sound.insert(sound.end(), block.begin(), block.end());
    }
    return sound;
}

TEST(HeardTicks, AreHeardOneByOne) {
    HeardTicks ticks(std::make_shared<ClipSound>());
    filled(ticks, 1);
    Sound heard;
    for (int block = 0; block < 5; ++block) {
        for (int k = 0; k < 10; ++k) ticks.push(tick_of(sliding(2, 0.1F)));
        const Sound more = filled(ticks, 1);
        heard.insert(heard.end(), more.begin(), more.end());
    }
    ContactSound direct;
    Sound wanted;
    add(wanted, direct, {}, 10);
    wanted.clear();
    add(wanted, direct, tick_of(sliding(2, 0.1F)), 50);
    ASSERT_EQ(heard.size(), wanted.size());
    for (std::size_t k = 0; k < heard.size(); ++k) ASSERT_EQ(heard[k].left, wanted[k].left) << k;
}

TEST(HeardTicks, MergeWhenDeviceLags) {
    HeardTicks ticks(std::make_shared<ClipSound>());
    filled(ticks, 1);
    for (int k = 0; k < 200; ++k) ticks.push(k == 20 ? tick_of(meeting(0.2F)) : HeardTick());
    EXPECT_GT(largest(filled(ticks, 1)), 0.05) << "the tap is lost, or comes too late";
}

TEST(HeardTicks, FadeWhenTheyRunDry) {
    HeardTicks ticks(std::make_shared<ClipSound>());
    filled(ticks, 1);
    for (int k = 0; k < 10; ++k) ticks.push(tick_of(sliding(2, 0.1F)));
    const Sound heard = filled(ticks, 30);
    const auto part = [&heard](int from_ms, int to_ms) {
        return Sound(heard.begin() + from_ms * 48, heard.begin() + to_ms * 48);
    };
    EXPECT_GT(loudness(part(10, 25)), 0.5 * loudness(part(0, 10))) << "a short wait is heard";
    EXPECT_EQ(largest(part(200, 300)), 0);
    EXPECT_LT(largest_step(heard), 0.2);
}

TEST(HeardTicks, EarlyTicksAreDropped) {
    HeardTicks ticks(std::make_shared<ClipSound>());
    for (int k = 0; k < 500; ++k) ticks.push(tick_of(meeting(0.2F)));
    EXPECT_EQ(largest(filled(ticks, 3)), 0);
}

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

    void consume(const HeardTick& tick, std::int64_t now_ms, std::int64_t passed = 1) {
        sound.consume(tick, passed, clip, now_ms);
    }
};

HeardTick tap() {
    HeardTick tick;
    tick.fingers[0] = {.touching = true, .stiffness = 1000, .met = 0.2F};
    return tick;
}

TEST(FilmedSound, AlignsWithFilmAfterGap) {
    Filmed filmed;
    filmed.consume({}, 5);
    EXPECT_EQ(filmed.loudest.size(), 6U);
    for (int k = 0; k < 4; ++k) filmed.consume({}, 9);  // they come four at a time
    EXPECT_EQ(filmed.loudest.size(), 10U);
    filmed.sound.align();  // 400 ms without a tick
    filmed.consume(tap(), 409);
    for (int k = 1; k < 20; ++k) filmed.consume({}, 409 + k);
    ASSERT_EQ(filmed.loudest.size(), 429U);
    for (std::size_t k = 0; k < 409; ++k) EXPECT_EQ(filmed.loudest[k], 0) << k;
    EXPECT_GT(filmed.loudest[412], 0.01F);
}

TEST(FilmedSound, FillsSkippedTicks) {
    Filmed filmed;
    filmed.consume({}, 100);  // 50 ms late, as it turns out
    for (int k = 51; k < 100; ++k) filmed.consume(k == 60 ? tap() : HeardTick{}, k);
    EXPECT_EQ(filmed.loudest.size(), 101U);
    filmed.consume({}, 100);
    filmed.consume({}, 101);
    for (int k = 102; k < 110; ++k) filmed.consume({}, k);
    EXPECT_EQ(filmed.loudest.size(), 110U);
    EXPECT_GT(filmed.loudest[104], 0.01F) << "the tap is lost";
    filmed.consume({}, 150, 41);
    EXPECT_EQ(filmed.loudest.size(), 151U);
}

/// What a file holds, up to where it is silent, of a finger that touches in ticks 200 to 899, by that force,
/// and in each, which stands for `ticks`, slips so far: scene units.
Sound saved_sound(double slip, const GuardedForce& felt, int ticks = 1) {
    const TemporaryFolder folder;
    auto sound = WindowSound::create(false, folder / "heard.wav", Existing::keep);
    EXPECT_TRUE(sound);
    TouchListener listener(**sound, 100);
    listener.begin(PlaybackClock(FrameRate()), 0);
    Contact contact;
    contact.touching = true;
    contact.goal.z = -0.1;
    contact.carried_stiffness = 1000;
    contact.ticks = ticks;
    for (int n = 200; n < 900; ++n) {
        contact.carried = std::exchange(contact.proxy, contact.proxy + glm::dvec3(slip, 0, 0));
        TouchTick tick;
        tick.tick = n;
        tick.metres_per_scene_unit = 0.001;
        tick.contacts = {&contact, 1};
        tick.forces = {&felt, 1};
        EXPECT_TRUE(listener.consume(tick));
    }
    EXPECT_TRUE((*sound)->finish());
    const auto saved = SpokenSound::read(folder / "heard.wav");
    Sound samples;
    EXPECT_TRUE(saved) << saved.error().message;
    if (!saved) return samples;
    for (const auto& [left, right] : (*saved)->samples)
        samples.push_back({static_cast<float>(left) / 32767, static_cast<float>(right) / 32767});
    return samples;
}

TEST(TouchListener, RestingFingerTapsOnce) {
    const Sound tap = saved_sound(0, {{0, 0, 2}});
    EXPECT_GT(largest(tap), 0.05);
    EXPECT_LT(tap.size(), 800U * ContactSound::samples_per_tick);
}

TEST(TouchListener, FrictionDoesNotPress) {
    const auto end_of = [](const Sound& slide) {
        EXPECT_NEAR(static_cast<double>(slide.size()), 900 * ContactSound::samples_per_tick, 48);
        return loudness({slide.end() - 9600, slide.end()});
    };
    const double free = end_of(saved_sound(0.05, {{0, 0, 1}}));
    EXPECT_GT(end_of(saved_sound(0.05, {{0, 0, 4}})), 1.3 * free);
    EXPECT_NEAR(end_of(saved_sound(0.05, {{-4, 0, 1}})), free, 0.02 * free);
    EXPECT_NEAR(end_of(saved_sound(0.2, {{0, 0, 1}}, 4)), free, 0.02 * free) << "three ticks were missed";
}

}  // namespace
}  // namespace touchable::test
