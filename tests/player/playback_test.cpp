// A clip that is paused, sought, looped, stepped and played at other speeds while fingers press on it.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>

#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

using Words = std::vector<std::string>;

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
class Pumping final : public ClipReader {
public:
    explicit Pumping(int noise = 0) : noise_(noise) {}
    static double depth(double seconds) { return 194 + 6 * std::abs(seconds - 1); }
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return clip_frames; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<void> rewind() override {
        number_ = 0;
        return {};
    }
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
    const Scene scene_ = pumping_scene();
    int noise_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    std::int64_t number_ = 0;
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
    Result<void> take(const TouchTick& tick) override {
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
    EXPECT_TRUE(TouchSession(scene, feed, hand, *solver, settings).run(sinks));
    EXPECT_EQ(taken.ticks.size(), static_cast<std::size_t>(ticks));
    return taken.ticks;
}

double spring_at(std::int64_t media_ns) {
    return 0.6 * (205 - Pumping::depth(1e-9 * static_cast<double>(media_ns)));
}

/// Of the largest jump, 6 mm, with a fifth for fades that overlap; and what the wall moves in a tick at
/// rate 8.
constexpr double steepest_fade = 1.2 * 0.6 * 6 * 1.5 / JumpCancellation::fade_ticks + 0.6 * 0.048 + 1e-4;

struct ScriptCase {
    const char* script;
    int jumps;             // at least
    std::uint64_t epochs;  // begun by the end
};

// Each of them moves the surface under the finger; without what keeps jumps away it would be up to 3.6 N.
TEST(Playback, WhateverIsAskedOfTheClockNoForceRisesFasterThanAFade) {
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

TEST(Playback, OfHeldFramesASeekIsAFadeToo) {
    const auto ticks = pressed("0.5 seek 1\n0.8 seek 0", 700, FrameInterpolation::hold);
    for (std::size_t k = 101; k < ticks.size(); ++k)
        ASSERT_LE(ticks[k].force - ticks[k - 1].force, 0.6 * 0.2 + steepest_fade) << k;
    EXPECT_TRUE(ticks[500].jumped);
}

TEST(Playback, APausedSurfaceStandsStill) {
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

class AverageOverTime : public testing::Test {
protected:
    AverageOverTime() {
        scene.filter.temporal = true;
        scene.filter.temporal_noise = {2, 0};
    }
    std::unique_ptr<SurfaceFeed> feed(bool reference = false) const {
        return std::make_unique<SurfaceFeed>(
            std::make_unique<Pumping>(900),
            reference ? make_reference_builder(scene) : make_cpu_builder(scene), scene);
    }
    /// Of frames `first` to `last`, by hand.
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

TEST_F(AverageOverTime, OfAnEpochIsThatOfTheSixteenFramesBeforeItAndItsOwn) {
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

TEST_F(PlayedClip, ReplaysToItsHashWithEveryBuilder) {
    make();
    const std::string play = script(
        "0.1 pause\n0.2 step   # a comment\n\n0.3 seek 1.2\n0.35 play\n0.4 rate 3\n0.5 loop 0.2 0.6\n"
        "0.8 rate 0.3\n0.9 unloop\n0.9 rate 1\n1.0 seek 0.1\n");
    for (const Words& filter : {Words{}, Words{"--temporal", "5"}}) {
        Words words{clip,        "--play", play,       "--fingers",       "2",
                    "--seconds", "1.2",    "--record", folder / "run.rec"};
        words.insert(words.end(), filter.begin(), filter.end());
        const auto run = touch(words);
        EXPECT_GT(run["contact_ticks"], 500);
        for (const char* builder : {"cpu", "reference"}) {
            const auto again = touch({"--replay", folder / "run.rec", "--builder", builder});
            EXPECT_EQ(again["force_hash"], run["force_hash"]) << builder;
            EXPECT_EQ(again["playback"], run["playback"]);
        }
        const Outcome said = run_touchable({"touch", "--replay", folder / "run.rec"});
        EXPECT_NE(said.out.find("every force is as recorded"), std::string::npos) << said.out << said.err;
        EXPECT_EQ(said.out.find("frames are not the recorded ones"), std::string::npos) << said.out;
    }
}

// At rate 1 a clip from a second on is what is left of it; in a loop it has no end of its own.
TEST_F(PlayedClip, OptionsSayWhereItBeginsHowFastItIsAndWhereItGoesBack) {
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

TEST_F(PlayedClip, WhatCannotBePlayedIsRefusedAndSaysWhatCould) {
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
        {{"--play", folder / "none.txt"},
         "none.txt: is not there; right would be a file of playback commands"},
        {{"--play", script("0.5 play\n0.4 pause\n")}, "line 2: tick 400 is before 500"}};
    for (const auto& [words, fragment] : wrong) {
        Words all{"touch", clip};
        all.insert(all.end(), words.begin(), words.end());
        const Outcome run = run_touchable(all);
        EXPECT_EQ(run.code, words[0] == "--play" ? 3 : 2) << fragment;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(fragment), std::string::npos) << fragment << " is missing in: " << run.err;
    }
    const std::string play = script("0 rate 2\n");
    const Outcome over = run_touchable({"touch", clip, "--play", play, "--json", play, "--overwrite"});
    EXPECT_EQ(over.code, 2) << "its own input";
    EXPECT_EQ(file_contents(play), "0 rate 2\n");
}

TEST(PlaybackScript, RefusesALineByItsNumber) {
    const std::pair<const char*, const char*> wrong[] = {
        {"soon play", "line 1: \"soon\" must be a time"},
        {"1 play\n\n-1 pause", "line 3: \"-1\" must be a time"},
        {"1", "must be play, pause, rate X"},
        {"1 jump 3", "\"jump\" is no command"},
        {"1 seek", "seek takes 1 numbers, not 0"},
        {"1 play 3", "play takes 0 numbers, not 1"},
        {"1 seek 3s", "\"3s\" must be a number"},
        {"1 rate 0.0001", "rate must be 0.001 to 8"},
        {"1 loop 2 1", "a loop must be 0.1 s or longer"}};
    for (const auto& [text, fragment] : wrong) {
        const auto refused = parse_playback(text, "a.txt");
        ASSERT_FALSE(refused) << text;
        EXPECT_EQ(refused.error().kind, ErrorKind::input);
        EXPECT_NE(refused.error().message.find(fragment), std::string::npos) << refused.error().message;
    }
    EXPECT_EQ(in_words(parse_playback("0.5 loop 1 2.25\n3 rate 0.333\n4 unloop", "").value()),
              "0.5 loop 1 2.25, 3 rate 0.333, 4 unloop");
}

}  // namespace
}  // namespace touchable::test
