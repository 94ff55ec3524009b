#include "player/run/run_files.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "engine/content/scenes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/full_disk.hpp"
#include "tests/player/program.hpp"
#include "tests/player/recording_bytes.hpp"

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
            EXPECT_TRUE((*recording)->take(one));
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
        EXPECT_NE(read_back.error().message.find(fragment), std::string::npos) << read_back.error().message;
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

TEST_F(RecordingFormat, WhatWasWrittenIsReadBackToTheBitNansToo) {
    const auto whole = read(bytes_);
    ASSERT_TRUE(whole) << whole.error().message;
    ASSERT_EQ(whole->size(), 1U);
    const RecordedPart* const recording = &whole->front();
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

TEST_F(RecordingFormat, LayoutIsAsDocumented) {
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

TEST_F(RecordingFormat, AnyChangedByteIsNoticed) {
    for (std::size_t at = 0; at < bytes_.size(); ++at)
        for (const int bit : {0, 7}) {
            std::string damaged = bytes_;
            damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
            const auto recording = read(damaged);
            ASSERT_FALSE(recording) << "byte " << at << " bit " << bit;
            EXPECT_EQ(recording.error().kind, ErrorKind::input);
        }
}

TEST_F(RecordingFormat, AnyMissingOrAddedByteIsNoticed) {
    for (std::size_t size = 0; size < bytes_.size(); ++size)
        ASSERT_FALSE(read(bytes_.substr(0, size))) << size << " bytes";
    EXPECT_FALSE(read(bytes_ + '\0'));
    EXPECT_FALSE(read(bytes_ + bytes_));
}

// A right hash does not make numbers right.
TEST_F(RecordingFormat, ImpossibleNumbersAreRefused) {
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
class PartsOfARecording : public RecordingFormat {
protected:
    PartsOfARecording() {
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
        EXPECT_TRUE(recording.take({static_cast<std::int64_t>(k),
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

TEST_F(PartsOfARecording, AreReadInTheirOrder) {
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

TEST_F(PartsOfARecording, AreRefusedWhereOneIsMissingOrDamaged) {
    EXPECT_TRUE(read(part(0) + part(1) + part(2))) << "as it was";
    for (const std::string& bytes :
         {part(0), part(1), part(2), part(0) + part(1), part(1) + part(2), part(0) + part(2),
          part(1) + part(0) + part(2), part(0) + part(0) + part(1) + part(2)})
        expect_refused(bytes, "a part is missing");
    for (std::size_t at = 0; at < bytes_.size(); at += 3) {
        std::string damaged = bytes_;
        damaged[at] = static_cast<char>(damaged[at] ^ 4);
        ASSERT_FALSE(read(damaged)) << "byte " << at;
        ASSERT_FALSE(read(bytes_.substr(0, at))) << at << " bytes";
    }
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
TEST_F(PartsOfARecording, AreKeptUpToWhereTheDiskBecameFull) {
    std::size_t kept_before = 0;
    for (std::size_t room = bytes_.size() % 7; room <= bytes_.size(); room += 7) {
        const std::string place = folder / "cut.rec";
        std::filesystem::remove(place);
        Result<void> finished;
        {
            const FullDisk full(room);
            auto recording = RecordingFile::create(place, 2, Existing::keep, Pace::wall_clock);
            ASSERT_TRUE(recording);
            take(**recording, 0);
            take(**recording, 1);
            (*recording)->end_part({{"name", "first"}}, playback_);
            take(**recording, 0);
            (*recording)->end_part({{"name", "second"}}, {});
            take(**recording, 2);
            finished = (*recording)->finish({{"name", "third"}}, {});
        }
        EXPECT_EQ(bool(finished), room == bytes_.size()) << room;
        if (!std::filesystem::exists(place)) {
            EXPECT_EQ(kept_before, 0U) << room;
            continue;
        }
        const auto recording = read_recording(place);
        ASSERT_TRUE(recording) << room << ": " << recording.error().message;
        const std::size_t kept = ticks_of(*recording);
        EXPECT_GE(kept, kept_before) << room;
        kept_before = kept;
        if (finished) continue;
        EXPECT_NE(finished.error().message.find("; it is kept, and replays, up to 0.24"), std::string::npos)
            << finished.error().message;
        ForceHash forces;
        for (std::size_t tick = 0; tick < recording->back().ticks.size(); ++tick)
            for (const glm::dvec3& force : recording->back().ticks[tick].forces) forces.add(force);
        EXPECT_EQ(recording->back().facts["force_hash"], forces.hex());
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

}  // namespace
}  // namespace touchable::test
