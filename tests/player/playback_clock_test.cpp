// Which moment of a clip a tick is of.
#include "player/run/playback.hpp"

#include <gtest/gtest.h>

#include "tests/frame/random.hpp"

namespace touchable::test {
namespace {

using Verb = PlaybackVerb;

constexpr std::int64_t ms = 1'000'000;

PlaybackClock clock_of(std::vector<PlaybackCommand> commands) {
    EXPECT_TRUE(validate(commands));
    return PlaybackClock({30, 1}, std::move(commands));
}

void expect_at(PlaybackClock& clock, std::int64_t tick, std::uint64_t epoch, std::int64_t time_ns) {
    const MediaMoment moment = clock.at(tick);
    EXPECT_EQ(moment.epoch, epoch) << "tick " << tick;
    EXPECT_EQ(moment.time_ns, time_ns) << "tick " << tick;
}

TEST(PlaybackClock, WithoutCommandsATickIsAMillisecond) {
    PlaybackClock clock = clock_of({});
    for (const std::int64_t tick : {0LL, 1LL, 999LL, 1'000'000'000LL}) expect_at(clock, tick, 0, tick * ms);
    EXPECT_FALSE(clock.next_epoch());
    EXPECT_TRUE(clock.plays_to_the_end());
    EXPECT_GT(clock.at(std::int64_t{1} << 62).time_ns, 0) << "no overflow";
}

TEST(PlaybackClock, PauseAndRateAreTheSameEpoch) {
    PlaybackClock clock = clock_of({{10, Verb::pause, 0, 0},
                                    {20, Verb::play, 0, 0},
                                    {30, Verb::rate, 333, 0},
                                    {33, Verb::rate, 8000, 0}});
    expect_at(clock, 9, 0, 9 * ms);
    expect_at(clock, 10, 0, 10 * ms);
    expect_at(clock, 19, 0, 10 * ms);
    expect_at(clock, 20, 0, 10 * ms);
    expect_at(clock, 21, 0, 11 * ms);
    expect_at(clock, 30, 0, 20 * ms);
    expect_at(clock, 32, 0, 20 * ms + 666'000);
    expect_at(clock, 33, 0, 20 * ms + 999'000);
    expect_at(clock, 34, 0, 28 * ms + 999'000);
    EXPECT_TRUE(clock.plays_to_the_end());
}

TEST(PlaybackClock, ASeekIsAnEpochAndKeepsThePause) {
    PlaybackClock clock = clock_of({{5, Verb::pause, 0, 0},
                                    {7, Verb::seek, 400 * ms, 0},
                                    {9, Verb::seek, 2 * ms, 0},
                                    {9, Verb::play, 0, 0}});
    expect_at(clock, 6, 0, 5 * ms);
    expect_at(clock, 7, 1, 400 * ms);
    expect_at(clock, 8, 1, 400 * ms);
    expect_at(clock, 9, 2, 2 * ms);
    expect_at(clock, 10, 2, 3 * ms);
    EXPECT_EQ(clock.at(11).start_ns, 2 * ms);
}

TEST(PlaybackClock, AStepGoesToTheNextFrameAndPauses) {
    PlaybackClock clock = clock_of({{40, Verb::step, 0, 0}, {50, Verb::step, 0, 0}, {51, Verb::step, 0, 0}});
    expect_at(clock, 39, 0, 39 * ms);
    expect_at(clock, 40, 0, 66'666'666);
    expect_at(clock, 49, 0, 66'666'666);
    expect_at(clock, 50, 0, 100 * ms);
    expect_at(clock, 51, 0, 133'333'333);
    expect_at(clock, 500, 0, 133'333'333);
    EXPECT_FALSE(clock.plays_to_the_end());
}

// At rate 3 a tick may come 2 ms beyond the loop's end; they are not lost.
TEST(PlaybackClock, ALoopsWayBackIsAnEpoch) {
    PlaybackClock clock =
        clock_of({{0, Verb::rate, 3000, 0}, {0, Verb::loop, 10 * ms, 110 * ms}, {100, Verb::unloop, 0, 0}});
    expect_at(clock, 36, 0, 108 * ms);
    expect_at(clock, 37, 1, 11 * ms);
    expect_at(clock, 69, 1, 107 * ms);
    expect_at(clock, 70, 2, 10 * ms);
    EXPECT_EQ(clock.at(70).start_ns, 10 * ms);
    expect_at(clock, 99, 2, 97 * ms);
    expect_at(clock, 200, 2, 400 * ms);
    EXPECT_TRUE(clock.plays_to_the_end());
}

TEST(PlaybackClock, WhoIsFarBeyondALoopsEndBeginsWithIt) {
    PlaybackClock clock = clock_of({{500, Verb::loop, 0, 100 * ms}});
    expect_at(clock, 499, 0, 499 * ms);
    expect_at(clock, 500, 1, 0);
    EXPECT_FALSE(clock.plays_to_the_end());
}

std::vector<PlaybackCommand> drawn_commands(Random& random) {
    std::vector<PlaybackCommand> commands;
    std::int64_t tick = 0;
    for (int k = 0; k < 12; ++k) {
        tick += random.below(120);
        const auto verb = static_cast<Verb>(random.below(7));
        const std::int64_t moment = random.below(500) * ms + random.below(1000);
        PlaybackCommand command{tick, verb, 0, 0};
        if (verb == Verb::rate) command.first = 1 + random.below(8000);
        if (verb == Verb::seek || verb == Verb::loop) command.first = moment;
        if (verb == Verb::loop) command.second = moment + shortest_loop_ns + random.below(100) * ms;
        commands.push_back(command);
    }
    return commands;
}

/// Tick by tick against a clock of which only some ticks are asked, and one that looks ahead.
void expect_pure(const std::vector<PlaybackCommand>& commands, Random& random) {
    PlaybackClock every = clock_of(commands), some = every, ahead = every;
    MediaMoment before = every.at(0);
    auto coming = before.epoch == 0 ? ahead.next_epoch() : std::nullopt;
    const bool follows = before.epoch == 0;
    for (std::int64_t tick = 1; tick < 3000; ++tick) {
        const MediaMoment now = every.at(tick);
        if (random.below(9) == 0) {
            ASSERT_EQ(some.at(tick), now);
        }
        if (now.epoch == before.epoch) {
            ASSERT_GE(now.time_ns, before.time_ns);
            ASSERT_EQ(now.start_ns, before.start_ns);
        } else {
            ASSERT_GT(now.epoch, before.epoch);
            while (follows && coming && coming->number < now.epoch) coming = ahead.next_epoch();
            if (follows) {
                ASSERT_TRUE(coming);
                ASSERT_EQ(coming->number, now.epoch);
                ASSERT_EQ(coming->start_ns, now.start_ns);
                if (now.epoch == before.epoch + 1) {
                    ASSERT_GE(coming->left_ns, before.time_ns);
                }
                coming = ahead.next_epoch();
            }
        }
        ASSERT_GE(now.time_ns, now.start_ns);
        before = now;
    }
}

TEST(PlaybackClock, IsAFunctionOfTheTickAndKnowsItsEpochsAhead) {
    Random random(41);
    for (int run = 0; run < 100; ++run) {
        SCOPED_TRACE(run);
        ASSERT_NO_FATAL_FAILURE(expect_pure(drawn_commands(random), random));
    }
}

TEST(PlaybackClock, RefusesWhatIsNoCommand) {
    const std::pair<PlaybackCommand, const char*> wrong[] = {
        {{-1, Verb::play, 0, 0}, "tick -1"},
        {{4, Verb::play, 0, 0}, "is before 5"},
        {{5, Verb::rate, 0, 0}, "0.001 to 8"},
        {{5, Verb::rate, 8001, 0}, "0.001 to 8"},
        {{5, Verb::seek, -1, 0}, "0 to 1e6 s"},
        {{5, Verb::seek, latest_moment_ns + 1, 0}, "0 to 1e6 s"},
        {{5, Verb::loop, 0, shortest_loop_ns - 1}, "0.1 s or longer"},
        {{5, Verb::loop, -5, shortest_loop_ns}, "0 to 1e6 s"},
        {{5, static_cast<Verb>(7), 0, 0}, "no command"}};
    for (const auto& [command, fragment] : wrong) {
        const auto refused = validate({{5, Verb::play, 0, 0}, command});
        ASSERT_FALSE(refused) << fragment;
        EXPECT_NE(refused.error().message.find("command 2: "), std::string::npos) << refused.error().message;
        EXPECT_NE(refused.error().message.find(fragment), std::string::npos) << refused.error().message;
    }
}

}  // namespace
}  // namespace touchable::test
