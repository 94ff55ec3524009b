// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "engine/content/scenes.hpp"
#include "engine/picture/image.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/run_files.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

/// Two fingers, four ticks over a still plane; whatever a hand may give and a guard may answer.
class RecordingFormat : public ::testing::Test {
protected:
    RecordingFormat() {
        SceneOptions options;
        options.width = 16;
        options.height = 12;
        const auto source = make_scene("plane", options);
        EXPECT_TRUE(make_reference_builder((*source)->scene())->build((*source)->frame(0), surface_));
        pair_.prev = {7, 233'333'333, &surface_};
        pair_.next = {8, 266'666'666, &surface_};
        pair_.epoch = 2;
        const HeightField field((*source)->scene(), pair_);
        auto recording = RecordingFile::create(file(), 2, Existing::replace);
        EXPECT_TRUE(recording);
        for (std::int64_t tick = 0; tick < 4; ++tick) {
            const auto k = static_cast<std::size_t>(tick);
            const TouchTick one{tick,      times_[k],  pair_, field.blend(), goals_[k],
                                contacts_, forces_[k], {},    0.001};
            EXPECT_TRUE((*recording)->consume(one));
        }
        EXPECT_TRUE((*recording)->finish(facts_, playback_));
        bytes_ = file_contents(file());
    }
    std::string file() const { return folder / "run.rec"; }
    Result<Recording> read(const std::string& bytes) const {
        // A new file each time: some file systems flush one that is cut to nothing and filled again.
        std::filesystem::remove(folder / "other.rec");
        std::ofstream(folder / "other.rec", std::ios::binary) << bytes;
        return read_recording(folder / "other.rec");
    }
    void expect_refused(const std::string& bytes, const std::string& fragment) const {
        const auto read_back = read(bytes);
        ASSERT_FALSE(read_back);
        EXPECT_EQ(read_back.error().kind, ErrorKind::input);
        EXPECT_PRED2(says, read_back.error().message, fragment);
    }

    TemporaryFolder folder;
    SurfaceFrame surface_;
    FramePair pair_;
    const std::vector<std::int64_t> times_{240'000'000, 241'000'000, 241'000'000, 243'000'001};
    const std::vector<std::vector<glm::dvec3>> goals_{{{1, -2, 3e-300}, {-0.0, 0, 1e300}},
                                                      {{nan, 0, 0}, {0, infinite, -infinite}},
                                                      {{5e-324, 0.1, 1.0 / 3}, {1, 2, 3}},
                                                      {{0, 0, 0}, {4, 5, 6}}};
    const std::vector<std::vector<GuardedForce>> forces_{
        {{{0.5, 0, -0.0}, guard_none}, {{1, 2, 3}, guard_ramp}},
        {{{0, 0, 0}, guard_fault}, {{0, 0, 0}, guard_fault}},
        {{{0.1, 0.2, 0.3}, guard_force | guard_stiffness}, {{1e-17, 0, 0}, guard_none}},
        {{{0, 0, 0}, guard_none}, {{0, 0, 0}, guard_none}}};
    const std::vector<Contact> contacts_{2};
    const std::vector<PlaybackCommand> playback_{{3, PlaybackVerb::loop, 5, 1'000'000'005},
                                                 {7, PlaybackVerb::step, 0, 0}};
    const nlohmann::ordered_json facts_{{"clip", "a clip"}, {"S", 0.1}};
    std::string bytes_;
};

void expect_same_bits(const glm::dvec3& a, const glm::dvec3& b) {
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_EQ(std::bit_cast<std::uint64_t>(a[axis]), std::bit_cast<std::uint64_t>(b[axis]));
}

TEST_F(RecordingFormat, RoundTripsEveryBit) {
    const auto whole = must(read(bytes_));
    ASSERT_EQ(whole.size(), 1U);
    const RecordedPart* const recording = &whole.front();
    EXPECT_EQ(recording->fingers, 2);
    EXPECT_EQ(nlohmann::json(recording->facts), nlohmann::json(facts_));
    EXPECT_EQ(recording->playback, playback_);
    ASSERT_EQ(recording->ticks.size(), 4U);
    for (std::size_t k = 0; k < 4; ++k) {
        const RecordedPart::Tick& tick = recording->ticks[k];
        EXPECT_EQ(tick.time_ns, times_[k]);
        EXPECT_EQ(tick.frame_prev, 7);
        EXPECT_EQ(tick.frame_next, 8);
        EXPECT_EQ(tick.blend, 0);
        EXPECT_EQ(tick.epoch, 2U);
        ASSERT_EQ(tick.goals.size(), 2U);
        for (std::size_t finger = 0; finger < 2; ++finger) {
            expect_same_bits(tick.goals[finger], goals_[k][finger]);
            expect_same_bits(tick.forces[finger], forces_[k][finger].force);
            EXPECT_EQ(tick.guards[finger], forces_[k][finger].reasons);
        }
    }
}

TEST_F(RecordingFormat, MatchesDocumentedLayout) {
    const RecordingBytes raw(bytes_);
    EXPECT_EQ(bytes_.substr(0, 8), "TOUCHREC");
    EXPECT_EQ(raw.integer(8, 4), 2U);
    EXPECT_EQ(raw.fingers(), 2U);
    EXPECT_EQ(raw.ticks(), 4U);
    EXPECT_EQ(raw.integer(raw.time_at(3), 8), 243'000'001U);
    EXPECT_EQ(raw.integer(raw.time_at(1) + 8, 8), 7U);
    EXPECT_EQ(raw.integer(raw.time_at(1) + 16, 8), 8U);
    EXPECT_EQ(raw.real(raw.blend_at(2)), 0);
    EXPECT_EQ(raw.real(raw.goal_at(3, 1) + 16), 6);
    EXPECT_EQ(raw.real(raw.force_at(2, 0) + 8), 0.2);
    EXPECT_EQ(raw.integer(raw.guard_at(2, 0), 4), 3U);
    EXPECT_EQ(raw.integer(raw.epoch_at(1), 8), 2U);
    EXPECT_EQ(raw.integer(raw.command_at(0), 8), 3U);
    EXPECT_EQ(raw.integer(raw.command_at(0) + 8, 4), 5U);
    EXPECT_EQ(raw.integer(raw.command_at(0) + 20, 8), 1'000'000'005U);
    EXPECT_EQ(raw.integer(raw.command_at(1), 8), 7U);
    EXPECT_EQ(raw.integer(raw.command_at(2), 8), 2U) << "how many there are";
    EXPECT_EQ(raw.facts(), facts_);
    RecordingBytes sealed = raw;
    sealed.set_facts(facts_.dump(2));
    EXPECT_EQ(sealed.bytes(), bytes_) << "the hash is that of all before it";
}

// A right hash does not make numbers right.
TEST_F(RecordingFormat, RejectsImpossibleNumbers) {
    const auto with = [&](std::size_t at, std::size_t size, std::uint64_t value) {
        RecordingBytes raw(bytes_);
        raw.set_integer(at, size, value);
        return raw.bytes();
    };
    const RecordingBytes raw(bytes_);
    const std::size_t facts_size = bytes_.size() - 24, ticks = bytes_.size() - 16;
    expect_refused(with(8, 4, 3), "format version 3; this program reads up to 2");
    for (const std::uint64_t version : {0, 1}) expect_refused(with(8, 4, version), "damaged");
    for (const std::uint64_t fingers : {0, 1, 3, 256, 257}) expect_refused(with(12, 4, fingers), "damaged");
    expect_refused(with(12, 4, 0xffffffff), "damaged");
    for (const std::uint64_t huge : {std::uint64_t{0}, std::uint64_t{1} << 32, ~std::uint64_t{0}}) {
        expect_refused(with(facts_size, 8, huge), "damaged");
        expect_refused(with(ticks, 8, huge), "damaged");
    }
    expect_refused(with(raw.time_at(2), 8, 240'999'999), "tick 2: its time is before");
    expect_refused(with(raw.time_at(3), 8, ~std::uint64_t{0}), "tick 3: its time is before");
    expect_refused(with(raw.epoch_at(2), 8, 1), "tick 2: its epoch is before");
    for (const std::uint64_t commands :
         {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{3}, ~std::uint64_t{0}})
        expect_refused(with(raw.command_at(2), 8, commands), "damaged");
    expect_refused(with(raw.command_at(1), 8, 2), "playback command 2: tick 2 is before 3");
    expect_refused(with(raw.command_at(0) + 8, 4, 99), "playback command 1: is no command");
    expect_refused(with(raw.command_at(0) + 20, 8, 6), "playback command 1: a loop must be");
    expect_refused(with(raw.time_at(3), 8, 1'000'000'000'000'001), "its last tick is later than 1e6 s");
    RecordingBytes none(bytes_);
    none.keep_ticks(0);
    expect_refused(none.bytes(), "no ticks");
    for (const char* text : {"", "{", "{\"clip\": }", "\xff", "[]", "3"}) {
        RecordingBytes other(bytes_);
        other.set_facts(text);
        expect_refused(other.bytes(), "damaged");
    }
}

/// A recording of three parts of 2, 1 and 1 ticks; between the last two one that got none.
class RecordingParts : public RecordingFormat {
protected:
    RecordingParts() {
        auto recording = RecordingFile::create(file(), 2, Existing::replace);
        EXPECT_TRUE(recording);
        take(**recording, 0);
        take(**recording, 1);
        (*recording)->end_part({{"name", "first"}}, playback_);
        take(**recording, 0);
        (*recording)->end_part({{"name", "second"}}, {});
        (*recording)->end_part({{"name", "none"}}, playback_);
        take(**recording, 2);
        EXPECT_TRUE((*recording)->finish({{"name", "third"}}, {}));
        bytes_ = file_contents(file());
        for (std::size_t at = bytes_.find("TOUCHREC"); at != std::string::npos;
             at = bytes_.find("TOUCHREC", at + 1))
            begins_.push_back(at);
        begins_.push_back(bytes_.size());
    }
    void take(RecordingFile& recording, std::size_t k) const {
        EXPECT_TRUE(recording.consume({static_cast<std::int64_t>(k),
                                       times_[k],
                                       pair_,
                                       0,
                                       goals_[k],
                                       contacts_,
                                       forces_[k],
                                       {},
                                       0.001}));
    }
    std::string part(std::size_t k) const { return bytes_.substr(begins_[k], begins_[k + 1] - begins_[k]); }

    std::vector<std::size_t> begins_;
};

TEST_F(RecordingParts, AreReadInOrder) {
    const auto recording = read(bytes_);
    ASSERT_TRUE(recording) << recording.error().message;
    ASSERT_EQ(recording->size(), 3U);
    const std::vector<std::size_t> ticks{2, 1, 1};
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ((*recording)[k].ticks.size(), ticks[k]);
        EXPECT_TRUE((*recording)[k].name.ends_with("other.rec, part " + std::to_string(k + 1)));
    }
    EXPECT_EQ((*recording)[0].playback, playback_);
    EXPECT_EQ((*recording)[2].ticks[0].time_ns, times_[2]);
    EXPECT_EQ((*recording)[1].facts,
              nlohmann::ordered_json({{"name", "second"}, {"part", 2}, {"goes_on", true}}));
    EXPECT_EQ((*recording)[2].facts, nlohmann::ordered_json({{"name", "third"}, {"part", 3}}));
    // Each is whole by itself, as documented: the bytes of a recording of one part but for its facts.
    const RecordingBytes third(part(2));
    EXPECT_EQ(third.ticks(), 1U);
    EXPECT_EQ(third.integer(third.time_at(0), 8), 241'000'000U);
}

TEST_F(RecordingParts, DetectAnyDamage) {
    for (std::size_t at = 0; at < bytes_.size(); ++at) {
        for (const int bit : {0, 7}) {
            std::string damaged = bytes_;
            damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
            const auto recording = read(damaged);
            ASSERT_FALSE(recording) << "byte " << at << " bit " << bit;
            EXPECT_EQ(recording.error().kind, ErrorKind::input);
        }
        ASSERT_FALSE(read(bytes_.substr(0, at))) << at << " bytes";
    }
    EXPECT_FALSE(read(bytes_ + '\0'));
    EXPECT_FALSE(read(bytes_ + bytes_));
}

TEST_F(RecordingParts, RejectMissingPart) {
    EXPECT_TRUE(read(part(0) + part(1) + part(2))) << "as it was";
    for (const std::string& bytes :
         {part(0), part(1), part(2), part(0) + part(1), part(1) + part(2), part(0) + part(2),
          part(1) + part(0) + part(2), part(0) + part(0) + part(1) + part(2)})
        expect_refused(bytes, "a part is missing");
    EXPECT_FALSE(read(bytes_.substr(0, bytes_.size() - 1)));
}

/// Ticks of all parts, and that the clock, names and hashes are those of these parts.
std::size_t ticks_of(const Recording& recording) {
    std::size_t ticks = 0;
    const std::vector<std::string> names{"first", "second", "third"};
    for (std::size_t k = 0; k < recording.size(); ++k) {
        EXPECT_EQ(recording[k].facts["name"], names[k]);
        ticks += recording[k].ticks.size();
    }
    return ticks;
}

// Wherever it becomes full: all parts and ticks for which there is room are there, and nothing else.
TEST_F(RecordingParts, SurviveFullDisk) {
    std::size_t kept_before = 0;
    for (std::size_t room = bytes_.size() % 7; room <= bytes_.size(); room += 7) {
        const std::string place = folder / "cut.rec";
        std::filesystem::remove(place);
        Result<void> finished;
        {
            const FullDisk full(room);
            auto recording = must(RecordingFile::create(place, 2, Existing::keep, Pace::wall_clock));
            take(*recording, 0);
            take(*recording, 1);
            recording->end_part({{"name", "first"}}, playback_);
            take(*recording, 0);
            recording->end_part({{"name", "second"}}, {});
            take(*recording, 2);
            finished = recording->finish({{"name", "third"}}, {});
        }
        EXPECT_EQ(bool(finished), room == bytes_.size()) << room;
        if (!std::filesystem::exists(place)) {
            EXPECT_EQ(kept_before, 0U) << room;
            continue;
        }
        const auto recording = must(read_recording(place));
        const std::size_t kept = ticks_of(recording);
        EXPECT_GE(kept, kept_before) << room;
        kept_before = kept;
        if (finished) continue;
        EXPECT_PRED2(says, finished.error().message, "; it is kept, and replays, up to 0.24");
        ForceHash forces;
        for (std::size_t tick = 0; tick < recording.back().ticks.size(); ++tick)
            for (const glm::dvec3& force : recording.back().ticks[tick].forces) forces.add(force);
        EXPECT_EQ(recording.back().facts["force_hash"], forces.hex());
    }
    EXPECT_EQ(kept_before, 4U);
}

TEST_F(RecordingFormat, UnfinishedRecordingLeavesNothing) {
    const TemporaryFolder empty;
    {
        auto recording = RecordingFile::create(empty / "run.rec", 1, Existing::keep);
        ASSERT_TRUE(recording);
        EXPECT_FALSE(std::filesystem::exists(empty / "run.rec")) << "no name until it is complete";
    }
    EXPECT_TRUE(names_in(empty.path()).empty());
}

TEST_F(RecordingFormat, NameHasOneWriter) {
    const TemporaryFolder there;
    std::filesystem::create_directory_symlink(there.path(), folder / "link");
    for (const Existing existing : {Existing::keep, Existing::replace}) {
        auto first = must(RecordingFile::create(there / "run.rec", 1, existing));
        EXPECT_TRUE(RecordingFile::create(there / "other.rec", 1, existing));
        const auto second = RecordingFile::create(folder / "link/run.rec", 1, existing);
        ASSERT_FALSE(second);
        EXPECT_PRED2(says, second.error().message, "link/run.rec: another run writes it; name another file");
        EXPECT_EQ(second.error().kind, ErrorKind::input);
        first.reset();
        EXPECT_TRUE(RecordingFile::create(there / "run.rec", 1, existing));
    }
}

// `touchable info --verify`, as a person calls it.

namespace fs = std::filesystem;

class ClipVerification : public ::testing::Test {
protected:
    struct Filmed {
        int frames = 6;
        int right = 0;     ///< pixels by which colour is moved
        int narrower = 0;  ///< boxes are in colour than in depth, by as many on each side
        double pulse = 0;  ///< depth is scaled by as much, frame by frame
        int blank = -1;    ///< this frame has no depth, nor has any before `from`
        int from = 0;
        int colour_period = 40;  ///< pixels from one box to the next in colour; in depth it is 40
    };
    /// Boxes before a wall, 160x120, in millimetres of 16 bits.
    std::string recording(const Filmed& filmed) const {
        const fs::path folder = at("recording");
        fs::create_directories(folder);
        for (int k = 0; k < filmed.frames; ++k) {
            Image depth{160, 120, 2, 1, {}}, colour{160, 120, 1, 3, {}};
            const double scale = 1 + filmed.pulse * (k % 3 - 1);
            for (int y = 0; y < 120; ++y)
                for (int x = 0; x < 160; ++x) {
                    const auto is_box = [&](int column, int period, int less = 0) {
                        const auto is_in = [&](int place) {
                            return place % period >= 15 + less && place % period < period - less;
                        };
                        return is_in(column + 2 * period) && is_in(y);
                    };
                    // Something moves, so that no frame repeats another.
                    const double mm = (is_box(x, 40) ? 700 : 1000) + (y < 8 ? 3 * k : 0);
                    const auto code = static_cast<std::uint16_t>(
                        std::lround(k == filmed.blank || k < filmed.from ? 0 : scale * mm));
                    depth.samples.push_back(static_cast<std::uint8_t>(code % 256));
                    depth.samples.push_back(static_cast<std::uint8_t>(code / 256));
                    for (int c = 0; c < 3; ++c)
                        colour.samples.push_back(
                            is_box(x - filmed.right, filmed.colour_period, filmed.narrower) == (c == 0) ? 200
                                                                                                        : 30);
                }
            const std::string number = "000" + std::to_string(k) + ".png";
            EXPECT_TRUE(write_png(folder / ("depth_" + number), depth.view()));
            EXPECT_TRUE(write_png(folder / ("color_" + number), colour.view()));
        }
        return folder.string();
    }
    nlohmann::json verified(const std::vector<std::string>& words) const {
        const Outcome run = succeed(plus({"info", "--verify", "--json"}, words));
        return nlohmann::json::parse(run.out, nullptr, false);
    }
    static std::set<std::string> names(const nlohmann::json& json) {
        std::set<std::string> names;
        for (const auto& finding : json.at("findings")) {
            names.insert(finding.at("name"));
            EXPECT_NE(finding.at("mend"), "");
        }
        return names;
    }
    std::string at(const std::string& name) const { return folder_ / name; }

    TemporaryFolder folder_;
};

TEST_F(ClipVerification, FindsNothingInGoodClip) {
    make_clip("globe", at("globe.mkv"), {"--size", "96x64", "--frames", "4"});
    EXPECT_EQ(names(verified({at("globe.mkv")})), std::set<std::string>{});
    const Outcome run = run_touchable({"info", at("globe.mkv"), "--verify"});
    EXPECT_PRED2(says, run.out, "nothing was found that would feel wrong");
}

TEST_F(ClipVerification, MarksMisalignedColour) {
    const std::string clip = recording({.right = 3});
    const auto json = verified({clip, "--depth-unit", "0.001", "--fov", "60", "--picture", at("where.png")});
    EXPECT_EQ(names(json), std::set<std::string>{"registration"}) << json;
    EXPECT_NEAR(json["measures"]["colour_edges"]["right"].get<double>(), 3, 0.01);
    const auto picture = read_image(at("where.png"));
    ASSERT_TRUE(picture) << picture.error().message;
    int red = 0;
    for (std::size_t k = 0; k < picture->samples.size(); k += 3)
        red += picture->samples[k] == 255 && picture->samples[k + 1] == 40 ? 1 : 0;
    EXPECT_GT(red, 100);
    // An earlier picture stays.
    const Outcome again = run_touchable({"info", clip, "--verify", "--picture", at("where.png")});
    EXPECT_EQ(again.code, 2) << again.err;
}

/// Boxes whose colour is narrower and moved: both findings are of the same edges.
TEST_F(ClipVerification, NamesColourOfMarks) {
    const std::vector<std::string> more{"--depth-unit", "0.001", "--fov", "60", "--picture"};
    const auto with = [&](std::vector<std::string> words, const std::string& picture) {
        words.insert(words.end(), more.begin(), more.end());
        words.push_back(at(picture));
        return words;
    };
    const auto json = verified(with({recording({.right = 3, .narrower = 2})}, "both.png"));
    EXPECT_EQ(names(json), (std::set<std::string>{"registration", "rims"}));
    for (const auto& finding : json["findings"]) EXPECT_EQ(finding.value("colour", ""), "red") << finding;
    // Depth that pulses has no place.
    std::vector<std::string> words{"info", "--verify"};
    const auto pulses = with({recording({.frames = 9, .pulse = 0.01})}, "none.png");
    words.insert(words.end(), pulses.begin(), pulses.end());
    const Outcome run = run_touchable(words);
    EXPECT_PRED2(says, run.out, "wrong        pumping");
    EXPECT_PRED2(says, run.out, "has no marks");
}

TEST_F(ClipVerification, ReportsMissingColour) {
    make_clip("bumps", at("grey.mkv"), {"--size", "96x64", "--frames", "4"});
    const Outcome run = run_touchable({"info", at("grey.mkv"), "--verify"});
    EXPECT_PRED2(says, run.out, "; no colour");
    EXPECT_EQ(run.out.find("too few edges"), std::string::npos) << run.out;
}

TEST_F(ClipVerification, ReportsUnrelatedColour) {
    const auto json = verified({recording({.colour_period = 31}), "--depth-unit", "0.001", "--fov", "60"});
    EXPECT_EQ(names(json), std::set<std::string>{"registration"}) << json;
    const std::string what = json["findings"][0]["what"];
    EXPECT_PRED2(says, what, "agree on a place");
}

TEST_F(ClipVerification, ReportsFramesWithoutDepth) {
    const auto json = verified({recording({.blank = 3}), "--depth-unit", "0.001", "--fov", "60"});
    EXPECT_EQ(names(json), std::set<std::string>{"blank"});
    const std::string what = json["findings"][0]["what"];
    EXPECT_PRED2(says, what, "the first is 3");
}

/// The kind of depth, its unit too, is found from the first frames that have any.
TEST_F(ClipVerification, OpensClipStartingBlank) {
    const std::string clip = recording({.from = 4});
    const auto json = verified({clip, "--fov", "60"});
    EXPECT_EQ(names(json), std::set<std::string>{"blank"});
    EXPECT_PRED2(says, json["findings"][0]["what"].get<std::string>(), "4 frames have");
    EXPECT_PRED2(says, json["notes"].dump(), "depth codes are millimetres") << json["notes"];
    succeed({"relief", clip, at("relief.mkv"), "--fov", "60"});
    expect_failure({"info", recording({.from = 6}), "--fov", "60"}, 3, "has no depth: all values are 0");
}

TEST_F(ClipVerification, ReportsPulsingDepth) {
    const auto json =
        verified({recording({.frames = 9, .pulse = 0.01}), "--depth-unit", "0.001", "--fov", "60"});
    EXPECT_TRUE(names(json).contains("pumping")) << json;
}

TEST_F(ClipVerification, ReportsMissingFilter) {
    make_clip("globe", at("globe.mkv"), {"--size", "192x128", "--frames", "4", "--bits", "8"});
    EXPECT_TRUE(names(verified({at("globe.mkv"), "--filters", "off"})).contains("terraces"));
    EXPECT_FALSE(names(verified({at("globe.mkv"), "--filters", "auto"})).contains("terraces"));
}

TEST_F(ClipVerification, PictureRequiresVerify) {
    expect_failure({"info", at("globe.mkv"), "--picture", at("where.png")}, 2, "--verify");
}

// A frame in which nothing that can be touched has changed is the one before once more; and in virtual time
// frames are begun before they are asked for, where their builder works at several.

constexpr int width = 20, height = 12;

struct PlannedPlanes {
    std::vector<std::uint8_t> depth = std::vector<std::uint8_t>(width * height, 100);
    std::vector<std::uint8_t> haptic = std::vector<std::uint8_t>(3 * width * height, 7);
    std::vector<std::uint8_t> heights = std::vector<std::uint8_t>(width * height, 3);
    std::vector<std::uint8_t> colour = std::vector<std::uint8_t>(3 * width * height, 50);
};

Scene planned_scene() {
    Scene scene;
    scene.width = width;
    scene.height = height;
    scene.camera = {20, 20, 9.5, 5.5};
    scene.depth.code_max = 255;
    scene.depth.near = 100;
    scene.depth.far = 200;
    return scene;
}

class Planned final : public OwnClip {
public:
    /// `fails_at`: the frame that cannot be read.
    explicit Planned(std::vector<PlannedPlanes> frames, std::int64_t fails_at = -1)
        : OwnClip(planned_scene(), std::ssize(frames)), frames_(std::move(frames)), fails_at_(fails_at) {}
    Result<std::optional<RawFrame>> next() override {
        if (number_ == count_) return std::optional<RawFrame>();
        if (number_ == fails_at_) return input_error("the disk is out");
        // Each frame in memory of its own, which is freed with its last holder.
        auto planes = std::make_shared<PlannedPlanes>(frames_[static_cast<std::size_t>(number_)]);
        RawFrame raw;
        raw.number = number_;
        raw.time_ns = scene_.rate.time_ns(number_);
        raw.depth = {planes->depth.data(), width, width, height, 1, 1};
        raw.haptic = {planes->haptic.data(), 3 * width, width, height, 1, 3};
        raw.height = {planes->heights.data(), width, width, height, 1, 1};
        raw.colour = {planes->colour.data(), 3 * width, width, height, 1, 3};
        raw.storage = std::move(planes);
        ++number_;
        return std::optional<RawFrame>(std::move(raw));
    }

private:
    std::vector<PlannedPlanes> frames_;
    const std::int64_t fails_at_;
};

class Counting final : public SurfaceBuilder {
public:
    explicit Counting(int& built, const Scene& scene = planned_scene())
        : built_(built), builder_(make_reference_builder(scene)) {}
    std::string_view name() const override { return "counting"; }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        ++built_;
        return builder_->build(raw, out);
    }

private:
    int& built_;
    std::unique_ptr<SurfaceBuilder> builder_;
};

TEST(UnchangedFrames, AreNotBuiltAgain) {
    PlannedPlanes still, new_colour, new_haptic, new_depth, new_height;
    new_colour.colour[5] = 1;
    new_haptic.haptic.back() = 8;
    new_depth = new_haptic;
    new_depth.depth.back() = 101;
    new_height = new_depth;
    new_height.heights.front() = 4;
    int built = 0;
    SurfaceFeed feed(std::make_unique<Planned>(std::vector{still, still, new_colour, new_haptic, new_depth,
                                                           new_depth, new_height, still}),
                     std::make_unique<Counting>(built), planned_scene());
    const Scene scene = planned_scene();
    const std::vector<int> built_by{1, 1, 1, 2, 3, 3, 4, 5};
    const SurfaceFrame* before = nullptr;
    for (std::int64_t n = 0; n < 8; ++n) {
        const auto pair = must(feed.pair_at(scene.rate.time_ns(n)));
        EXPECT_EQ(pair.prev.number, n);
        EXPECT_EQ(pair.prev.time_ns, scene.rate.time_ns(n));
        const auto k = static_cast<std::size_t>(n);
        EXPECT_EQ(pair.prev.frame == before, n > 0 && built_by[k] == built_by[k - 1]) << n;
        EXPECT_EQ(pair.prev.frame->codes[width * height - 1], n >= 4 && n < 7 ? 101 : 100) << n;
        EXPECT_EQ(built, built_by[std::min(k + 1, built_by.size() - 1)]) << "with the frame after";
        before = pair.prev.frame;
    }
    EXPECT_EQ(feed.frames(), 8);
    EXPECT_EQ(feed.end_ns(), scene.rate.time_ns(8));
}

// From 100 to 101 levels: what is shown nears the new one frame by frame, though nothing in the clip changes.
TEST(UnchangedFrames, AreRebuiltByTemporalFilter) {
    Scene scene = planned_scene();
    scene.filter.temporal = true;
    scene.filter.temporal_noise = {1, 0};
    PlannedPlanes still, moved;
    moved.depth.assign(moved.depth.size(), 101);
    int built = 0;
    SurfaceFeed feed(std::make_unique<Planned>(std::vector{still, still, moved, moved, moved, moved}),
                     std::make_unique<Counting>(built, scene), scene);
    const int expected[] = {0, 0, 32, 56, 74, 87};
    for (std::int64_t n = 0; n < 6; ++n) {
        const auto pair = must(feed.pair_at(scene.rate.time_ns(n)));
        EXPECT_EQ(pair.prev.frame->codes[0], 126 * 100 + expected[n]) << n;
    }
    EXPECT_EQ(built, 6);
}

// More of them than the timeline has entries, with a hand that does not move on.
TEST(UnchangedFrames, WaitForHand) {
    int built = 0;
    SurfaceFeed feed(std::make_unique<Planned>(std::vector<PlannedPlanes>(60)),
                     std::make_unique<Counting>(built), planned_scene());
    int published = 0;
    auto raw = feed.read_next();
    while (raw && *raw) {
        const auto done = must(feed.publish(**raw));
        if (!done) break;
        ++published;
        raw = feed.read_next();
    }
    EXPECT_GT(published, 3);
    EXPECT_LT(published, 60);
    EXPECT_EQ(built, 1);
    FramePair pair;
    ASSERT_TRUE(feed.timeline().pair_at((*raw)->raw.time_ns, pair));
    const auto later = feed.publish(**raw);
    EXPECT_TRUE(later && *later);
}

/// Works at three frames, which it builds when they are finished.
class ThreeAtOnce final : public SurfaceBuilder {
public:
    explicit ThreeAtOnce(std::size_t& most) : most_(most) {}
    std::string_view name() const override { return "three"; }
    int frames_in_flight() const override { return 3; }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        EXPECT_TRUE(begun_.empty());
        return builder_->build(raw, out);
    }
    Result<void> begin(const RawFrame& raw) override {
        begun_.push_back(raw);
        most_ = std::max(most_, begun_.size());
        return {};
    }
    Result<void> finish(SurfaceFrame& out) override {
        const RawFrame raw = std::move(begun_.front());
        begun_.pop_front();
        return builder_->build(raw, out);
    }

private:
    std::size_t& most_;
    std::unique_ptr<SurfaceBuilder> builder_ = make_reference_builder(planned_scene());
    std::deque<RawFrame> begun_;
};

/// Frames of which the first are each the one before once more or another one in turn.
std::vector<PlannedPlanes> some_frames() {
    std::vector<PlannedPlanes> frames(9);
    for (std::size_t n = 0; n < frames.size(); ++n)
        frames[n].depth.back() = static_cast<std::uint8_t>(100 + 3 * (n < 4 ? n / 2 : n));
    return frames;
}

TEST(FramesAhead, GiveSamePairsEveryEpoch) {
    const Scene scene = planned_scene();
    std::size_t most = 0;
    int built = 0;
    SurfaceFeed ahead(std::make_unique<Planned>(some_frames()), std::make_unique<ThreeAtOnce>(most), scene),
        plain(std::make_unique<Planned>(some_frames()), std::make_unique<Counting>(built), scene);
    ahead.work_ahead();
    const auto compare = [&](const MediaMoment& moment) {
        const FramePair a = must(ahead.pair_at(moment)), b = must(plain.pair_at(moment));
        EXPECT_EQ(a.prev.number, b.prev.number);
        EXPECT_EQ(a.next.number, b.next.number);
        EXPECT_EQ(a.epoch, b.epoch);
        EXPECT_EQ(a.prev.frame->codes, b.prev.frame->codes) << b.prev.number;
        EXPECT_EQ(a.next.frame->codes, b.next.frame->codes) << b.next.number;
    };
    const auto time = [&](std::int64_t frame) { return scene.rate.time_ns(frame); };
    for (std::int64_t n = 0; n < 4; ++n) compare({0, time(n), 0});
    for (std::int64_t n = 2; n < 12; ++n) compare({1, time(n), time(2)});
    for (std::int64_t n = 7; n < 12; ++n) compare({2, time(n), time(7)});
    for (std::int64_t n = 0; n < 3; ++n) compare({3, time(n), 0});
    EXPECT_EQ(most, 3U);
    EXPECT_EQ(ahead.frames(), plain.frames());
    EXPECT_EQ(ahead.skipped_share(), plain.skipped_share());
    EXPECT_EQ(ahead.built(), plain.built());
    EXPECT_EQ(ahead.planes_hash(), plain.planes_hash());
}

/// As for a feed that threads ask for its frames: it begins none ahead.
TEST(FramesAhead, AreOffByDefault) {
    std::size_t most = 0;
    SurfaceFeed feed(std::make_unique<Planned>(some_frames()), std::make_unique<ThreeAtOnce>(most),
                     planned_scene());
    must(feed.pair_at(0));
    EXPECT_EQ(most, 1U);
    EXPECT_EQ(feed.place().next_number, 2);
}

TEST(FramesAhead, DelayErrorUntilItsFrame) {
    std::size_t most = 0;
    SurfaceFeed feed(std::make_unique<Planned>(some_frames(), 5), std::make_unique<ThreeAtOnce>(most),
                     planned_scene());
    feed.work_ahead();
    const FrameRate rate = planned_scene().rate;
    for (std::int64_t n = 0; n < 4; ++n) EXPECT_TRUE(feed.pair_at(rate.time_ns(n))) << n;
    expect_error(feed.pair_at(rate.time_ns(4)), "the disk is out");
}

// What a feed keeps for an eye.

/// The memory of one frame's planes may be another's later.
class OneMemory final : public OwnClip {
public:
    OneMemory() : OwnClip(planned_scene(), 60) {}
    Result<std::optional<RawFrame>> next() override {
        RawFrame raw;
        raw.number = number_;
        raw.time_ns = scene_.rate.time_ns(number_++);
        raw.depth = {planes_->depth.data(), width, width, height, 1, 1};
        raw.colour = {planes_->colour.data(), 3 * width, width, height, 1, 3};
        raw.storage = planes_;
        return std::optional(std::move(raw));
    }

private:
    std::shared_ptr<PlannedPlanes> planes_ = std::make_shared<PlannedPlanes>();
};

TEST(WatchedFeed, NumbersColoursOfEachFrame) {
    SurfaceFeed feed(std::make_unique<OneMemory>(), make_reference_builder(planned_scene()), planned_scene(),
                     temporal_warm_up_frames, SurfaceTimeline::Eye::one);
    auto frame = feed.read_next();
    while (must(feed.publish(**frame))) frame = feed.read_next();  // until there is no room
    const RawFrame& last = (*frame)->raw;
    const auto content = [&feed](std::int64_t number) {
        return feed.stored_planes(0, number)->colour.content;
    };
    const auto before = content(last.number - 1), now = content(last.number);
    EXPECT_NE(before, 0U);
    EXPECT_NE(now, before);
    EXPECT_FALSE(feed.stored_planes(0, last.number - 1)) << "not needed any longer";
    FramePair pair;
    ASSERT_TRUE(feed.timeline().pair_at(last.time_ns, pair));
    EXPECT_TRUE(must(feed.publish(**frame)));
    EXPECT_EQ(content(last.number), now);
}

/// A slope from 100 to 1100 codes with a plateau of `code` over `share` of its columns.
struct Slope {
    std::int64_t number;
    int code;
    double share;
};

class Slopes final : public OwnClip {
public:
    explicit Slopes(std::vector<Slope> slopes) : OwnClip(planned_scene()), slopes_(std::move(slopes)) {
        scene_.depth.code_max = scene_.depth.valid_max = 65535;
        scene_.depth_bits = 16;
    }
    Result<void> seek(std::int64_t frame) override {
        number_ = std::ranges::find(slopes_, frame, &Slope::number) - slopes_.begin();
        return {};
    }
    Result<std::optional<RawFrame>> next() override {
        if (number_ == std::ssize(slopes_)) return std::optional<RawFrame>();
        const auto& [number, code, share] = slopes_[static_cast<std::size_t>(number_++)];
        const auto codes = std::make_shared<std::vector<std::uint16_t>>();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                codes->push_back(
                    static_cast<std::uint16_t>(x < share * width ? code : 100 + 1000 * y / height));
        RawFrame raw;
        raw.number = number;
        raw.time_ns = scene_.rate.time_ns(number);
        raw.depth = plane_of_codes(codes->data(), width, height);
        raw.storage = codes;
        return std::optional(std::move(raw));
    }

private:
    const std::vector<Slope> slopes_;
};

TEST(WatchedFeed, FindsSuddenChangesOfDepth) {
    auto clip = std::make_unique<Slopes>(std::vector<Slope>{{0, 0, 0},
                                                            {1, 600, 0.3},  // a person comes
                                                            {2, 640, 0.5},  // nearer, and moves
                                                            {3, 640, 0.5},
                                                            {4, 1100, 1},
                                                            {5, 1100, 1},
                                                            {6, 100, 1},
                                                            {40, 1100, 1},
                                                            {41, 0, 0}});
    const Scene scene = clip->scene();
    SurfaceFeed feed(std::move(clip), make_reference_builder(scene), scene, temporal_warm_up_frames,
                     SurfaceTimeline::Eye::one);
    const auto cuts_at = [&](std::uint64_t epoch, std::int64_t frame, std::int64_t start) {
        must(feed.pair_at({epoch, scene.rate.time_ns(frame), scene.rate.time_ns(start)}));
        return feed.cuts();
    };
    EXPECT_EQ(cuts_at(0, 2, 0), std::set<std::int64_t>{});
    EXPECT_EQ(cuts_at(0, 4, 0), std::set<std::int64_t>{4});
    EXPECT_EQ(cuts_at(1, 6, 6), std::set<std::int64_t>{4}) << "a seek, and frames that are left out";
    EXPECT_EQ(cuts_at(1, 40, 6), (std::set<std::int64_t>{4, 41}));
}

TEST(UnchangedFrames, AppearInReport) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "still.mkv", {"--size", "72x48", "--frames", "5"});
    make_clip("moving", folder / "moving.mkv", {"--size", "72x48", "--frames", "5"});
    EXPECT_EQ(touch({folder / "still.mkv", "--hand", "wander"})["skipped_tiles_pct"], 80);
    EXPECT_EQ(touch({folder / "moving.mkv", "--hand", "wander"})["skipped_tiles_pct"], 0);
}

}  // namespace
}  // namespace touchable::test
