// SPDX-License-Identifier: Apache-2.0
// A clip that is paused, sought, looped, stepped and played at other speeds while fingers press on it.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "haptics_cpu/force_guard.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/sweep.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

constexpr int clip_frames = 60;  // 2 s

Scene pumping_scene() {
    Scene scene;
    scene.width = 16;
    scene.height = 12;
    scene.camera = {40, 40, 8, 6};
    scene.depth.code_max = 65535;
    scene.depth.valid_max = 65535;
    scene.depth.near = 100;
    scene.depth.far = 300;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth_bits = 16;
    scene.default_properties = {600, 0, 0};
    return scene;
}

/// A wall that comes 6 mm nearer in a second and goes back in the next, from 200 mm on; and of its depth some
/// noise, codes.
class Pumping final : public OwnClip {
public:
    explicit Pumping(int noise = 0) : OwnClip(pumping_scene(), clip_frames), noise_(noise) {}
    static double depth(double seconds) { return 194 + 6 * std::abs(seconds - 1); }
    Result<std::optional<RawFrame>> next() override {
        if (number_ == clip_frames) return std::optional<RawFrame>();
        const double wall = depth(static_cast<double>(number_) / 30);
        const auto code = static_cast<std::int64_t>(std::lround((300 - wall) / 200 * 65535));
        auto codes = std::make_shared<std::vector<std::uint16_t>>();
        for (std::int64_t k = 0; k < 16 * 12; ++k)
            codes->push_back(
                static_cast<std::uint16_t>(code + (noise_ > 0 ? (number_ * 7919 + k * 104729) % noise_ : 0)));
        RawFrame raw;
        raw.number = number_;
        raw.time_ns = scene_.rate.time_ns(number_++);
        raw.depth = {reinterpret_cast<const std::uint8_t*>(codes->data()), 32, 16, 12, 2, 1};
        raw.storage = std::move(codes);
        return std::optional(std::move(raw));
    }

private:
    int noise_;
};

/// Rests 5 mm behind where the wall is at 200 mm.
class Resting final : public Hand {
public:
    int fingers() const override { return 1; }
    void goals_at(std::int64_t, const SurfaceProbe&, std::span<glm::dvec3> goals) override {
        goals[0] = {0, 0, -205};
    }
};

struct PressedTick {
    MediaMoment moment;
    double force;
    bool jumped;
};

class PressedTicks final : public TouchSink {
public:
    explicit PressedTicks(PlaybackClock clock) : clock_(std::move(clock)) {}
    Result<void> consume(const TouchTick& tick) override {
        EXPECT_EQ(tick.pair.epoch, clock_.at(tick.tick).epoch) << tick.tick;
        ticks.push_back({clock_.at(tick.tick), tick.forces[0].force.z, tick.contacts[0].jumped});
        return {};
    }
    std::vector<PressedTick> ticks;

private:
    PlaybackClock clock_;
};

std::vector<PressedTick> pressed(const std::string& script, std::int64_t ticks,
                                 FrameInterpolation interpolation = FrameInterpolation::linear) {
    Scene scene = pumping_scene();
    scene.interpolation = interpolation;
    TouchSessionSettings settings;
    settings.playback = parse_playback(script, "script").value();
    settings.touch.metres_per_scene_unit = 0.001;
    settings.ticks = ticks;
    SurfaceFeed feed(std::make_unique<Pumping>(), make_reference_builder(scene), scene);
    Resting hand;
    const auto solver = TouchSolver::create(scene, settings.touch);
    PressedTicks taken(PlaybackClock(scene.rate, settings.playback));
    TouchSink* const sinks[] = {&taken};
    EXPECT_TRUE(TouchSession(feed, hand, *solver, settings).run(sinks));
    EXPECT_EQ(taken.ticks.size(), static_cast<std::size_t>(ticks));
    return taken.ticks;
}

double spring_at(std::int64_t media_ns) {
    return 0.6 * (205 - Pumping::depth(1e-9 * static_cast<double>(media_ns)));
}

/// N a tick: the fade of the largest jump, 6 mm, with a fifth for fades that overlap, and the wall's motion
/// in a tick at rate 8.
constexpr double steepest_fade = 1.2 * 0.6 * 6 * 1.5 / JumpCancellation::fade_ticks + 0.6 * 0.048 + 1e-4;

struct ScriptCase {
    const char* script;
    int jumps;             // at least
    std::uint64_t epochs;  // begun by the end
};

// Each of them moves the surface under the finger; without what keeps jumps away it would be up to 3.6 N.
TEST(Playback, CommandsFadeForceChanges) {
    for (const auto& [script, jumps, epochs] :
         {ScriptCase{"0.5 seek 1\n0.8 seek 0", 2, 2}, ScriptCase{"0.2 loop 0 0.95", 1, 1},
          ScriptCase{"0.3 pause\n0.5 seek 1\n0.6 seek 1.4\n0.7 seek 0.2", 3, 3},
          ScriptCase{"0.3 pause\n0.4 step\n0.5 step\n0.501 step\n0.502 step", 4, 0},
          ScriptCase{"0.2 rate 8\n0.3 rate 0.01\n0.6 rate 1", 0, 0},
          ScriptCase{"0 rate 4\n0 loop 0.5 1\n0.9 unloop", 5, 6}}) {
        SCOPED_TRACE(script);
        const auto ticks = pressed(script, 1200);
        double most = 0;
        int jumped = 0;
        for (std::size_t k = 101; k < ticks.size(); ++k) {  // the guard has ramped in
            most = std::max(most, ticks[k].force - ticks[k - 1].force);
            jumped += ticks[k].jumped;
            EXPECT_LE(ticks[k].force, spring_at(ticks[k].moment.time_ns) + 2e-3) << k;
        }
        EXPECT_LE(most, steepest_fade);
        EXPECT_GE(jumped, jumps);
        EXPECT_EQ(ticks.back().moment.epoch, epochs);
        EXPECT_NEAR(ticks.back().force, spring_at(ticks.back().moment.time_ns), 0.08);
    }
}

TEST(Playback, SeekFadesBetweenHeldFrames) {
    const auto ticks = pressed("0.5 seek 1\n0.8 seek 0", 700, FrameInterpolation::hold);
    for (std::size_t k = 101; k < ticks.size(); ++k)
        ASSERT_LE(ticks[k].force - ticks[k - 1].force, 0.6 * 0.2 + steepest_fade) << k;
    EXPECT_TRUE(ticks[500].jumped);
}

TEST(Playback, PausedSurfaceStandsStill) {
    const auto ticks = pressed("0.7 pause\n1.1 play", 1200);
    for (std::size_t k = 701; k < 1100; ++k) ASSERT_EQ(ticks[k].force, ticks[700].force);
    EXPECT_GT(ticks[1150].force, ticks[700].force + 0.1);
}

/// Codes of the earlier frame at a moment.
std::vector<std::uint16_t> codes_at(SurfaceFeed& feed, const MediaMoment& moment) {
    const auto pair = feed.pair_at(moment);
    EXPECT_TRUE(pair) << pair.error().message;
    const SurfaceFrame& frame = *pair->prev.frame;
    return {frame.codes.data(), frame.codes.data() + frame.codes.size()};
}

class TemporalAverage : public testing::Test {
protected:
    TemporalAverage() {
        scene.filter.temporal = true;
        scene.filter.temporal_noise = {2, 0};
    }
    std::unique_ptr<SurfaceFeed> feed(bool reference = false) const {
        return std::make_unique<SurfaceFeed>(
            std::make_unique<Pumping>(900),
            reference ? make_reference_builder(scene) : make_cpu_builder(scene), scene);
    }
    /// The average of frames `first` to `last`, by hand.
    std::vector<std::uint16_t> averaged(std::int64_t first, std::int64_t last) const {
        Pumping reader(900);
        const auto builder = make_reference_builder(scene);
        SurfaceFrame out;
        for (std::int64_t n = 0; n <= last; ++n) {
            const auto raw = reader.next();
            if (n < first) continue;
            EXPECT_TRUE(builder->build(**raw, out));
        }
        return {out.codes.data(), out.codes.data() + out.codes.size()};
    }
    MediaMoment at(std::uint64_t epoch, std::int64_t frame, std::int64_t start) const {
        return {epoch, scene.rate.time_ns(frame), scene.rate.time_ns(start)};
    }
    Scene scene = pumping_scene();
};

TEST_F(TemporalAverage, StartsSixteenFramesBeforeEpoch) {
    ASSERT_NE(averaged(14, 30), averaged(13, 30)) << "the noise is not what tells them apart";
    const auto played = feed(), fresh = feed(), other = feed(true);
    for (const std::int64_t n : {0, 10, 21}) EXPECT_EQ(codes_at(*played, at(0, n, 0)), averaged(0, n)) << n;
    for (const std::int64_t n : {30, 31, 40}) {
        const auto wanted = averaged(14, n);
        EXPECT_EQ(codes_at(*played, at(1, n, 30)), wanted) << n;
        EXPECT_EQ(codes_at(*fresh, at(1, n, 30)), wanted) << n;
        EXPECT_EQ(codes_at(*other, at(3, n, 30)), wanted) << n;
    }
    // Back, to where there are not so many; and on, so that what is read next follows what was read last.
    EXPECT_EQ(codes_at(*played, at(2, 5, 5)), averaged(0, 5));
    EXPECT_EQ(played->built().back(), (FrameRun{0, 7}));
    EXPECT_EQ(codes_at(*played, at(3, 23, 23)), averaged(7, 23));
    EXPECT_EQ(played->built().back(), (FrameRun{0, 25})) << "one after the other, as it happens";
    EXPECT_EQ(played->pair_at(at(2, 5, 5))->epoch, 3U) << "there is no way back";
}

class PlayedClip : public testing::Test {
protected:
    void make() const { make_clip("moving", clip, {"--size", "32x24", "--frames", "45"}); }
    std::string script(const std::string& text) const {
        std::ofstream(folder / "play.txt") << text;
        return folder / "play.txt";
    }
    TemporaryFolder folder;
    std::string clip = folder / "clip.mkv";
};

TEST_F(PlayedClip, ReplaysWithEveryBuilder) {
    make();
    const std::string play = script(
        "0.1 pause\n0.2 step   # a comment\n\n0.3 seek 1.2\n0.35 play\n0.4 rate 3\n0.5 loop 0.2 0.6\n"
        "0.8 rate 0.3\n0.9 unloop\n0.9 rate 1\n1.0 seek 0.1\n");
    for (const Words& filter : {Words{}, Words{"--temporal", "5"}}) {
        const auto run = touch(
            plus({clip, "--play", play, "--fingers", "2", "--seconds", "1.2", "--record", folder / "run.rec"},
                 filter));
        EXPECT_GT(run["contact_ticks"], 500);
        const auto facts = RecordingBytes(file_contents(folder / "run.rec")).facts();
        std::int64_t frames = 0;
        for (const auto& pair : facts.at("built")) frames += pair[1].get<std::int64_t>();
        EXPECT_EQ(facts["frames"], frames);
        for (const char* builder : {"cpu", "reference", "vulkan"}) {  // the last one begins frames ahead
            const auto again = touch({"--replay", folder / "run.rec", "--builder", builder});
            EXPECT_EQ(again["force_hash"], run["force_hash"]) << builder;
            EXPECT_EQ(again["playback"], run["playback"]);
        }
        const Outcome said = run_touchable({"touch", "--replay", folder / "run.rec"});
        EXPECT_PRED2(says, said.out, "every force is as recorded");
        EXPECT_EQ(said.out.find("frames are not the recorded ones"), std::string::npos) << said.out;
    }
}

// At rate 1 a clip from a second on is what is left of it; in a loop it has no end of its own.
TEST_F(PlayedClip, OptionsMatchScript) {
    make();
    const Words hand{"--hand", "wander", "--seconds", "0.3"};
    const auto hash = [&](Words words) {
        words.insert(words.begin(), clip);
        words.insert(words.end(), hand.begin(), hand.end());
        return force_hash(words);
    };
    EXPECT_EQ(hash({"--start", "0.5"}), hash({"--play", script("0 seek 0.5")}));
    EXPECT_NE(hash({"--start", "0.5"}), hash({}));
    EXPECT_EQ(hash({"--rate", "2"}), hash({"--play", script("0 rate 2")}));
    EXPECT_EQ(hash({"--rate", "1"}), hash({}));
    EXPECT_EQ(hash({"--loop", "0.1", "0.2"}), hash({"--play", script("0 seek 0.1\n0 loop 0.1 0.2")}));
    EXPECT_EQ(touch({clip, "--rate", "0.3"})["ticks"], 5000) << "1.5 s";
    EXPECT_EQ(touch({clip, "--start", "1"})["ticks"], 3000) << "no run is shorter";
}

TEST_F(PlayedClip, RejectsInvalidOptions) {
    make();
    const std::pair<Words, const char*> wrong[] = {
        {{"--start", "-1"}, "--start"},
        {{"--start", "nan"}, "--start"},
        {{"--start", "1.5"}, "the clip ends at 1.500000 s (--start)"},
        {{"--loop", "1.6", "2"}, "the clip ends at 1.500000 s (--loop)"},
        {{"--rate", "0"}, "--rate"},
        {{"--rate", "9"}, "--rate"},
        {{"--loop", "1"}, "--loop"},
        {{"--loop", "1", "1.05"}, "--loop must end 0.1 s"},
        {{"--loop", "0", "1"}, "how long to touch must be said (--seconds)"},
        {{"--play", folder / "none.txt"}, "none.txt: does not exist; expected a file of playback commands"},
        {{"--play", script("0.5 play\n0.4 pause\n")}, "line 2: tick 400 is before 500"}};
    for (const auto& [words, fragment] : wrong) {
        const Outcome run = run_touchable(plus({"touch", clip}, words));
        EXPECT_EQ(run.code, words[0] == "--play" ? 3 : 2) << fragment;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_PRED2(says, run.err, fragment);
    }
    const std::string play = script("0 rate 2\n");
    const Outcome over = run_touchable({"touch", clip, "--play", play, "--json", play, "--overwrite"});
    EXPECT_EQ(over.code, 2) << "its own input";
    EXPECT_EQ(file_contents(play), "0 rate 2\n");
}

TEST(PlaybackScript, RejectsLineByNumber) {
    const std::pair<const char*, const char*> wrong[] = {
        {"soon play", "line 1: \"soon\" must be a time"},
        {"1 play\n\n-1 pause", "line 3: \"-1\" must be a time"},
        {"1", "must be play, pause, rate X"},
        {"1 jump 3", "\"jump\" is no command"},
        {"1 seek", "seek takes 1 numbers, not 0"},
        {"1 play 3", "play takes 0 numbers, not 1"},
        {"1 seek 3s", "\"3s\" must be a number"},
        {"1 rate 9", "rate must be 0.001 to 8"},
        {"1 seek 1e7", "0 to 1e6"},
        {"1 loop 2 1", "a loop must be 0.1 s or longer"}};
    for (const auto& [text, fragment] : wrong) {
        const auto refused = parse_playback(text, "a.txt");
        ASSERT_FALSE(refused) << text;
        EXPECT_EQ(refused.error().kind, ErrorKind::input);
        EXPECT_PRED2(says, refused.error().message, fragment);
    }
    EXPECT_EQ(in_words(parse_playback("0.5 loop 1 2.25\n3 rate 0.333\n4 unloop", "").value()),
              "0.5 loop 1 2.25, 3 rate 0.333, 4 unloop");
}

// Which moment of a clip a tick is of.

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

TEST(PlaybackClock, TickIsOneMillisecond) {
    PlaybackClock clock = clock_of({});
    for (const std::int64_t tick : {0LL, 1LL, 999LL, 1'000'000'000LL}) expect_at(clock, tick, 0, tick * ms);
    EXPECT_FALSE(clock.next_epoch());
    EXPECT_TRUE(clock.plays_to_the_end());
    EXPECT_GT(clock.at(std::int64_t{1} << 62).time_ns, 0) << "no overflow";
}

TEST(PlaybackClock, PauseAndRateKeepEpoch) {
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

TEST(PlaybackClock, SeekKeepsPause) {
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

TEST(PlaybackClock, StepPausesAtNextFrame) {
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
TEST(PlaybackClock, LoopRestartBeginsEpoch) {
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

TEST(PlaybackClock, LoopBehindClockStartsOver) {
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

// 4e18 ns after the clip's begin; nanoseconds of later ticks would not fit in 64 bits.
TEST(PlaybackClock, StandsStillAtEndOfTime) {
    PlaybackClock clock = clock_of({{0, PlaybackVerb::seek, latest_moment_ns, 0}});
    const MediaMoment end = clock.at(std::numeric_limits<std::int64_t>::max() / 2);
    EXPECT_EQ(end.time_ns / 1'000'000, 4'000'000'000'000);
    EXPECT_EQ(clock.at(std::numeric_limits<std::int64_t>::max() / 2 + 1), end);
}

TEST(PlaybackClock, PredictsEpochsFromTick) {
    Random random(41);
    for (int run = 0; run < 100; ++run) {
        SCOPED_TRACE(run);
        ASSERT_NO_FATAL_FAILURE(expect_pure(drawn_commands(random), random));
    }
}

TEST(PlaybackClock, RejectsInvalidCommands) {
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
        EXPECT_PRED2(says, refused.error().message, "command 2: ");
        EXPECT_PRED2(says, refused.error().message, fragment);
    }
}

// `./run` on a machine that lacks what it needs.

namespace fs = std::filesystem;

struct Answer {
    int code = -1;
    std::string text;
};

/// The answer of `./run` with these words where no other programs are than those in `path`.
Answer run_script(const std::string& words, const fs::path& path, const std::string& through = "") {
    const std::string command = "PATH='" + path.string() + "' " + through + " '" + (path / "bash").string() +
                                "' '" TOUCHABLE_SOURCE_DIR "/run' " + words + " 2>&1";
    Answer answer;
    FILE* script = popen(command.c_str(), "r");
    std::array<char, 256> some;
    while (std::fgets(some.data(), some.size(), script)) answer.text += some.data();
    answer.code = WEXITSTATUS(pclose(script));
    return answer;
}

TEST(RunScript, NamesMissingPrograms) {
    const TemporaryFolder path;
    for (const char* name : {"bash", "dirname", "nproc"}) {
        fs::path program = fs::path("/usr/bin") / name;
        ASSERT_TRUE(fs::exists(program)) << program;
        fs::create_symlink(program, path / name);
    }
    for (const char* words :
         {"build --no-install", "build program --no-install", "test --no-install", "demo --no-install"}) {
        const Answer answer = run_script(words, path.path());
        EXPECT_EQ(answer.code, 2) << words;
        EXPECT_EQ(std::count(answer.text.begin(), answer.text.end(), '\n'), 1) << answer.text;
        for (const char* missing :
             {"g++ (Debian: g++)", "cmake (Debian: cmake)", "ninja (Debian: ninja-build)"})
            EXPECT_PRED2(says, answer.text, missing);
    }
    std::error_code failure;
    fs::create_symlink("/usr/bin/true", path / "cmake", failure);
    EXPECT_EQ(run_script("build --no-install", path.path()).text.find("cmake"), std::string::npos);
}

TEST(RunScript, RejectsWindowWithoutDisplay) {
    const Answer answer =
        run_script("demo --window --no-install", "/usr/bin", "env -u DISPLAY -u WAYLAND_DISPLAY");
    EXPECT_EQ(answer.code, 2) << answer.text;
    EXPECT_EQ(std::count(answer.text.begin(), answer.text.end(), '\n'), 1) << answer.text;
    EXPECT_PRED2(says, answer.text, "./run demo touches the globe without");
}

/// A program of a folder, as a script.
void put_script(const fs::path& path, const std::string& text) {
    std::ofstream(path) << "#!/usr/bin/bash\n" << text << '\n';
    fs::permissions(path, fs::perms::owner_all);
}

TEST(RunScript, PrintsRootCommandWithoutSudo) {
    const TemporaryFolder path;
    for (const char* name : {"bash", "dirname", "nproc"})
        fs::create_symlink(fs::path("/usr/bin") / name, path / name);
    put_script(path / "id", "echo 1000");
    put_script(path / "dpkg-query", "exit 1");  // nothing is installed
    // The tests may themselves have been asked for by `./run test --no-install`.
    const std::string through = "/usr/bin/env -u TOUCHABLE_INSTALL";
    const Answer alone = run_script("demo", path.path(), through);
    EXPECT_EQ(alone.code, 2) << alone.text;
    EXPECT_EQ(std::count(alone.text.begin(), alone.text.end(), '\n'), 1) << alone.text;
    EXPECT_PRED2(says, alone.text,
                 " packages are missing, and there is no sudo; as root: ./run install plots\n");
    put_script(path / "sudo", "echo asked; exit 1");
    const Answer answer = run_script("build", path.path(), through);
    EXPECT_EQ(answer.code, 2) << answer.text;
    EXPECT_EQ(answer.text.find("asked"), answer.text.rfind("asked")) << answer.text;
    EXPECT_EQ(answer.text.find(" g++ "), answer.text.rfind(" g++ ")) << answer.text;
    EXPECT_PRED2(says, answer.text, "\nrun: sudo failed; as root: ./run install tests\n");
    for (const std::string words : {"program program", "release tests", "fuzz sanitizers"})
        EXPECT_PRED2(says, run_script("build " + words, path.path(), through).text,
                     "./run install" + words.substr(words.find(' ')) + '\n');
}

TEST(RunScript, NamesGroupsAndUnknownCommands) {
    const std::string groups =
        "addon blender cross deb everything plots portable program proof sanitizers tests web wheel\n";
    EXPECT_EQ(run_script("install", "/usr/bin").text,
              "run: install needs one group of packages or more: " + groups);
    EXPECT_EQ(run_script("install plot", "/usr/bin").text,
              "run: 'plot' is not a group of packages; the groups are: " + groups);
    const Answer help = run_script("help", "/usr/bin"), answer = run_script("demo --windo", "/usr/bin");
    EXPECT_EQ(answer.code, 2);
    EXPECT_EQ(answer.text, help.text + "\nrun: unknown command 'demo --windo'\n");
    std::istringstream names(groups);
    for (std::string name; names >> name;)
        EXPECT_TRUE(std::regex_search(help.text, std::regex("install GROUP .*\\b" + name + "\\b"))) << name;
}

TEST(RunScript, IsAllThatWorkflowsCall) {
    const std::string help = run_script("help", "/usr/bin").text;
    std::string all;
    for (const auto& file : fs::directory_iterator(TOUCHABLE_SOURCE_DIR "/.github/workflows"))
        all += file_contents(file.path());
    std::istringstream lines(all);
    for (std::string line; std::getline(lines, line);) {
        const std::string command = line.substr(std::min(line.find("run: "), line.size()));
        if (command.empty() || says(command, "apt-get install -y --no-install-recommends git")) continue;
        ASSERT_TRUE(command.starts_with("run: ./run ")) << line;
        EXPECT_PRED2(says, help, command.substr(5, command.find(' ', 11) - 5)) << line;
    }
    for (const char* words : {"bookworm", "trixie", "run: ./run test --ci"}) EXPECT_PRED2(says, all, words);
}

// The globe fills 80 % of the picture's height; what is behind it pushes back, too.
TEST(RunScript, DemoFingersStayOnGlobe) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", forces = folder / "forces.csv";
    const double width = 360, height = 240;
    succeed({"make", "globe", clip, "--size", "360x240", "--frames", "90"});
    const std::regex in_words(R"(globe\.mkv"? (?:--live )?--hand (\S+) --fingers 5)");
    std::set<std::string> hands;
    int commands = 0;
    for (const char* file : {TOUCHABLE_SOURCE_DIR "/run", TOUCHABLE_SOURCE_DIR "/README.md"}) {
        const std::string text = file_contents(file);
        for (std::sregex_iterator match(text.begin(), text.end(), in_words), end; match != end; ++match) {
            hands.insert((*match)[1]);
            ++commands;
        }
    }
    EXPECT_EQ(commands, 3) << "two of the demo, and the README's";
    for (const std::string& hand : hands) {
        succeed({"touch", clip, "--hand", hand, "--fingers", "5", "--forces", forces, "--overwrite"});
        std::array<int, 5> touching{};
        double farthest = 0;
        for (const ForcesRow& row : read_forces(forces)) {
            if (row["contact"] == 0) continue;
            ++touching.at(static_cast<std::size_t>(row["finger"]));
            farthest = std::max(farthest, std::hypot(row["pixel_x"] - 0.5 * (width - 1),
                                                     row["pixel_y"] - 0.5 * (height - 1)));
        }
        EXPECT_LT(farthest, 0.8 * height / 2) << hand;
        for (const int ticks : touching) EXPECT_GT(ticks, 2500) << hand << ": of 3000";
    }
}

// The hand's part of the energy that the guard's books have.

/// A finger that goes into a wall at 0, 1 N/mm, and out of it again; scene units are metres.
class SentEnergyBooks : public ::testing::Test {
protected:
    SentEnergyBooks() {
        settings_.ramp_in_ticks = 0;
        guard_.emplace(settings_, 1.0);
    }
    /// The tick's force, newtons; `share` of it is sent.
    double press(double depth, double share) {
        Contact contact;
        contact.goal = {0, 0, -depth};
        contact.touching = depth > 0;
        contact.proxy = contact.touching ? glm::dvec3(0) : contact.goal;
        contact.carried = contact.proxy;
        if (was_touching_) contact.carried_stiffness = 1000;
        contact.properties.stiffness = contact.touching ? 1000 : 0;
        contact.force = 1000.0 * (contact.proxy - contact.goal);
        was_touching_ = contact.touching;
        const glm::dvec3 step = contact.goal - goal_;
        goal_ = contact.goal;
        work_ += glm::dot(held_, step);
        const GuardedForce out = guard_->guard(contact);
        held_ = share * out.force;
        guarded_ = out.energy;
        sent_.update(out.energy, share);
        return out.force.z;
    }
    /// In and out once, 5 mm deep, in steps of 0.1 mm; `share_of` each tick.
    template <class Share>
    void stroke(const Share& share_of) {
        for (int k = 0; k <= 120; ++k) press(0.0001 * (60 - std::abs(60 - k)) - 0.001, share_of(k));
    }

    GuardSettings settings_;
    std::optional<ForceGuard> guard_;
    bool was_touching_ = false;
    glm::dvec3 goal_{0, 0, 0.001}, held_{0};
    double work_ = 0;  // that the sent forces did
    EnergyFigures guarded_;
    TouchFigures::SentEnergy sent_;
};

TEST_F(SentEnergyBooks, MatchGuardAtFullShare) {
    stroke([](int) { return 1.0; });
    ASSERT_GT(guarded_.bound, 0);
    const EnergyFigures& sent = sent_.figures();
    for (const auto figure : {&EnergyFigures::work, &EnergyFigures::surface, &EnergyFigures::stored,
                              &EnergyFigures::created, &EnergyFigures::bound})
        EXPECT_EQ(sent.*figure, guarded_.*figure);
}

TEST_F(SentEnergyBooks, AreZeroAtZeroShare) {
    stroke([](int) { return 0.0; });
    ASSERT_GT(guarded_.created, 0);
    const EnergyFigures& sent = sent_.figures();
    EXPECT_NEAR(sent.work, 0, 1e-15);
    EXPECT_NEAR(sent.created, 0, 1e-15);
    EXPECT_NEAR(sent.bound, 0, 1e-15);
    EXPECT_NEAR(sent.surface, 0, 1e-15);
}

TEST_F(SentEnergyBooks, CountWorkOfSentForces) {
    stroke([](int k) { return k < 40 ? 0.0 : std::min(1.0, (k - 40) / 50.0); });
    const EnergyFigures& sent = sent_.figures();
    EXPECT_NEAR(sent.work, work_, 1e-12);
    EXPECT_GT(std::abs(sent.work - guarded_.work), 0.001);
    // The share rose under a finger that was pressed in: as a ramp does, that put energy into the spring.
    EXPECT_GT(sent.surface, 0.001);
    EXPECT_LE(sent.created, sent.bound * (1 + 1e-9));
    EXPECT_LT(sent.bound, guarded_.bound);
}

}  // namespace
}  // namespace touchable::test
