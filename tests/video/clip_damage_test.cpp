#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <optional>

#include "engine/clip/clip_file.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/sweep.hpp"
#include "tests/video/clip_remux.hpp"

namespace touchable::test {
namespace {

/// What can be told of a clip: everything, or the error.
struct Outcome {
    std::string error;
    std::string scene;
    std::vector<RawFrame> frames;
};

Outcome outcome_of(const std::filesystem::path& file) {
    auto reader = open_clip(file);
    if (!reader) return {reader.error().message, "", {}};
    auto frames = read_all(**reader);
    if (!frames) return {frames.error().message, "", {}};
    return {"", scene_to_json((*reader)->scene()), std::move(*frames)};
}

bool same_outcome(const Outcome& a, const Outcome& b) {
    return a.scene == b.scene &&
           std::equal(a.frames.begin(), a.frames.end(), b.frames.begin(), b.frames.end(), same_frame);
}

/// Whether a clip that was cut is the other one up to a frame.
bool begins_as(const Outcome& whole, const Outcome& cut) {
    return cut.scene == whole.scene && !cut.frames.empty() && cut.frames.size() <= whole.frames.size() &&
           std::equal(cut.frames.begin(), cut.frames.end(), whole.frames.begin(), same_frame);
}

/// A clip as bytes, what it holds, and a place to put damaged copies.
struct Subject {
    Subject(int side, int frames, int depth_bits, const Planes& planes = all_planes,
            const ClipStorage& storage = exact_clip) {
        const Scene scene = small_scene(side, side, depth_bits);
        EXPECT_EQ(message(write_clip(folder / "whole.mkv", scene, frames, planes, storage)), "");
        bytes = read_bytes(folder / "whole.mkv");
        whole = outcome_of(folder / "whole.mkv");
        EXPECT_EQ(whole.error, "");
    }
    Outcome with(const std::string& damaged) const {
        std::filesystem::remove(folder /
                                "damaged.mkv");  // some file systems flush a file that is cut and rewritten
        write_bytes(folder / "damaged.mkv", damaged);
        return outcome_of(folder / "damaged.mkv");
    }
    TemporaryFolder folder;
    std::string bytes;
    Outcome whole;
};

TEST(ClipDamage, TruncationIsErrorOrFirstFrames) {
    const Subject subject(8, 3, 16);
    for (std::size_t length = 0; length < subject.bytes.size(); length += sweep_step()) {
        const Outcome cut = subject.with(subject.bytes.substr(0, length));
        ASSERT_TRUE(!cut.error.empty() || begins_as(subject.whole, cut))
            << length << " of " << subject.bytes.size();
        ASSERT_TRUE(cut.error.empty() || cut.error.find("damaged.mkv: ") != std::string::npos) << cut.error;
    }
    EXPECT_NE(subject.with(subject.bytes.substr(0, subject.bytes.size() / 2)).error.find("is truncated"),
              std::string::npos);
    EXPECT_NE(subject.with("").error.find("is empty"), std::string::npos);
}

/// Of a few frames in a cluster each.
TEST(ClipDamage, CutClipEndsWithLastCluster) {
    const Subject subject(64, 12, 16);
    std::size_t before = 0;
    for (const double share : {0.3, 0.5, 0.51, 0.7, 0.9, 0.97}) {
        const auto length = static_cast<std::size_t>(share * static_cast<double>(subject.bytes.size()));
        const Outcome cut = subject.with(subject.bytes.substr(0, length));
        ASSERT_EQ(cut.error, "") << share;
        const std::size_t frames = cut.frames.size();
        EXPECT_NEAR(static_cast<double>(frames), share * 12, 1.5);
        EXPECT_GE(frames, before);
        ASSERT_LE(frames, 12U);
        before = frames;
        EXPECT_TRUE(
            std::equal(cut.frames.begin(), cut.frames.end(), subject.whole.frames.begin(), same_frame));
        auto reader = open_clip(subject.folder / "damaged.mkv");
        ASSERT_EQ(message(reader), "");
        EXPECT_EQ((*reader)->frame_count(), std::optional(static_cast<std::int64_t>(frames)));
        const auto& notes = (*reader)->notes();
        const std::string note = "the file is cut: its first " + std::to_string(frames) + " frames are whole";
        EXPECT_EQ(std::count(notes.begin(), notes.end(), note), frames < 12 ? 1 : 0) << share;
        for (const std::size_t frame : {frames - 1, std::size_t{0}, frames / 2}) {
            ASSERT_EQ(message((*reader)->seek(static_cast<std::int64_t>(frame))), "");
            const auto there = (*reader)->next();
            ASSERT_EQ(message(there), "");
            ASSERT_TRUE(*there);
            EXPECT_TRUE(same_frame(**there, subject.whole.frames[frame])) << share << ": " << frame;
        }
    }
}

/// As a writer that was stopped leaves it: the segment's size and the duration not filled in.
TEST(ClipDamage, ClipThatWasNeverCompletedSaysSo) {
    const Subject subject(8, 3, 16);
    const std::string segment("\x18\x53\x80\x67", 4);
    std::string live = subject.bytes;
    const auto at = live.find(segment);
    ASSERT_NE(at, std::string::npos);
    live.replace(at + 4, 8, "\x01\xff\xff\xff\xff\xff\xff\xff");
    EXPECT_NE(subject.with(live).error.find("was never completed"), std::string::npos);
}

void expect_every_change_is_found(const Subject& subject) {
    std::size_t refused = 0;
    constexpr int changes[] = {0x01, 0x80, 0xff};
    for (std::size_t at = 0; at < subject.bytes.size(); at += sweep_step()) {
        std::string damaged = subject.bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ changes[at % 3]);
        const Outcome outcome = subject.with(damaged);
        ASSERT_TRUE(!outcome.error.empty() || same_outcome(outcome, subject.whole))
            << "byte " << at << " of " << subject.bytes.size();
        refused += outcome.error.empty() ? 0 : 1;
    }
    EXPECT_GT(refused, subject.bytes.size() / sweep_step() / 2);
}

TEST(ClipDamage, EveryChangedByteIsAnErrorOrChangesNothing) {
    constexpr Planes depth_and_haptic{false, true};  // all tracks are alike, and FFmpeg opens H.264 slowly
    expect_every_change_is_found(Subject(8, 2, 12, depth_and_haptic));
}

TEST(ClipDamage, EveryChangedByteOfASmallClipIsAnErrorOrChangesNothing) {
    const Subject subject(8, 2, 12, all_planes, {Archive::small, true});
    auto reader = open_clip(subject.folder / "whole.mkv");
    ASSERT_EQ(message(reader), "");
    const char* expected[] = {"t3d2", "ffv1", "ffv1", "ffv1"};
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ((*reader)->tracks()[k].codec, expected[k]);
    expect_every_change_is_found(subject);
}

TEST(ClipDamage, ChangedPayloadNamesTrackAndFrame) {
    const Subject subject(40, 3, 10);
    const std::vector<std::string> payloads = packets(subject.folder / "whole.mkv");
    ASSERT_EQ(payloads.size(), 12U);
    const char* roles[] = {"depth", "colour", "haptic", "height"};
    Numbers numbers(5);
    for (std::size_t k = 0; k < payloads.size(); ++k) {
        const auto begin = subject.bytes.find(payloads[k]);
        ASSERT_NE(begin, std::string::npos);
        for (int trial = 0; trial < 20; ++trial) {
            std::string damaged = subject.bytes;
            char& byte = damaged[begin + static_cast<std::size_t>(
                                             numbers.below(static_cast<int>(payloads[k].size())))];
            byte = static_cast<char>(byte ^ (1 << numbers.below(8)));
            const Outcome outcome = subject.with(damaged);
            const std::string expected = "damaged.mkv: track " + std::string(roles[k % 4]) + ", frame " +
                                         std::to_string(k / 4) + ": is damaged";
            ASSERT_NE(outcome.error.find(expected), std::string::npos) << outcome.error;
        }
    }
}

/// Some bytes between `begin` and `end` become others.
std::string scattered(std::string bytes, std::size_t begin, std::size_t end, Numbers& numbers) {
    for (int k = numbers.below(30); k >= 0; --k)
        bytes[begin + static_cast<std::size_t>(numbers.below(static_cast<int>(end - begin)))] =
            static_cast<char>(numbers.below(256));
    return bytes;
}

TEST(ClipDamage, HeavyDamageAmongTheFramesIsAnErrorOrChangesNothing) {
    const Subject subject(24, 3, 16);
    const auto clusters = subject.bytes.find("\x1F\x43\xB6\x75"),
               cues = subject.bytes.rfind("\x1C\x53\xBB\x6B");
    ASSERT_LT(clusters, cues);
    ASSERT_NE(cues, std::string::npos);
    Numbers numbers(7);
    for (int trial = 0; trial < 500; ++trial) {
        const Outcome outcome = subject.with(scattered(subject.bytes, clusters, cues, numbers));
        ASSERT_TRUE(!outcome.error.empty() || same_outcome(outcome, subject.whole)) << "trial " << trial;
    }
}

/// Files of other writers may carry no checksums for what is not payload. Damage there may pass, but not
/// crash: tests/fuzz.
TEST(ClipDamage, AClipMayCarryNoChecksums) {
    const Subject subject(24, 3, 16);
    Remux changes;
    changes.checksums = false;
    remux(subject.folder / "whole.mkv", subject.folder / "bare.mkv", changes);
    const std::string bytes = read_bytes(subject.folder / "bare.mkv");
    EXPECT_TRUE(same_outcome(subject.with(bytes), subject.whole));
}

TEST(ClipDamage, OtherFilesAreNotClips) {
    const TemporaryFolder folder;
    write_bytes(folder / "noise.mkv", std::string(5000, 'x'));
    EXPECT_TRUE(is_refused(open_clip(folder / "noise.mkv"), "is not a Matroska file"));
    EXPECT_TRUE(is_refused(open_clip(folder / "none.mkv"), "does not exist"));
    EXPECT_TRUE(is_refused(open_clip("/dev/null"), "is neither a file nor a folder"));
}

TEST(ClipWriting, NothingIsLeftBehindWithoutFinish) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(16, 16);
    {
        auto writer = create_clip(folder / "clip.mkv", scene);
        ASSERT_EQ(message(writer), "");
        ASSERT_EQ(message((*writer)->write(test_frame(scene, 0, {}))), "");
        EXPECT_FALSE(std::filesystem::exists(folder / "clip.mkv"));
    }
    EXPECT_EQ(folder.file_count(), 0U);
    {
        auto writer = create_clip(folder / "clip.mkv", scene);
        ASSERT_EQ(message(writer), "");
        EXPECT_TRUE(is_refused((*writer)->finish(), "no frame was given"));
    }
    EXPECT_EQ(folder.file_count(), 0U);
}

TEST(ClipWriting, AnOlderFileStaysUntilTheNewOneIsWhole) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(16, 16);
    write_bytes(folder / "clip.mkv", "older");
    {
        auto writer = create_clip(folder / "clip.mkv", scene);
        ASSERT_EQ(message(writer), "");
        ASSERT_EQ(message((*writer)->write(test_frame(scene, 0, {}))), "");
    }
    EXPECT_EQ(read_bytes(folder / "clip.mkv"), "older");
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 2, {})), "");
    EXPECT_EQ(message(read_clip(folder / "clip.mkv")), "");
    EXPECT_EQ(folder.file_count(), 1U);
}

TEST(ClipWriting, PlacesThatCannotBeWrittenAreNamed) {
    const TemporaryFolder folder;
    write_bytes(folder / "file", "x");
    for (const auto& path : {folder / "absent" / "clip.mkv", folder / "file" / "clip.mkv"}) {
        const auto writer = create_clip(path, small_scene(8, 8));
        ASSERT_FALSE(writer);
        EXPECT_EQ(writer.error().kind, ErrorKind::input);
        EXPECT_NE(writer.error().message.find(path.string() + ": cannot be written: "), std::string::npos);
    }
    std::filesystem::create_directory(folder / "taken.mkv");
    for (const auto& path : {folder / "taken.mkv", std::filesystem::path("/dev/null")})  // before any frame
        EXPECT_TRUE(
            is_refused(create_clip(path, small_scene(8, 8)), path.string() + ": is not the name of a file"));
    EXPECT_EQ(folder.file_count(), 2U);
}

TEST(ClipWriting, FullDiskIsAnErrorAndLeavesNothing) {
    const TemporaryFolder folder;
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
    rlimit limit = before;
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    for (const rlim_t size : {1U, 1000U, 100'000U, 400'000U}) {
        limit.rlim_cur = size;  // a file that would grow beyond this fails to be written, as on a full disk
        setrlimit(RLIMIT_FSIZE, &limit);
        const auto result = write_clip(folder / "clip.mkv", small_scene(128, 128, 16), 20, all_planes);
        setrlimit(RLIMIT_FSIZE, &before);
        ASSERT_FALSE(result) << size;
        EXPECT_NE(result.error().message.find("clip.mkv: cannot be written: "), std::string::npos)
            << message(result);
        EXPECT_EQ(folder.file_count(), 0U);
    }
    std::signal(SIGXFSZ, old_handler);
}

TEST(ClipWriting, FramesThatDoNotBelongAreRefused) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(16, 16, 10);
    const auto second = [&](const RawFrame& frame) {
        auto writer = create_clip(folder / "clip.mkv", scene);
        EXPECT_EQ(message((*writer)->write(test_frame(scene, 0, {true}))), "");
        const std::string error = message((*writer)->write(frame));
        EXPECT_NE(message((*writer)->finish()), "");  // a clip that lacks a frame is not given its name
        return error;
    };
    EXPECT_NE(second(test_frame(scene, 2, {true})).find("number 1 was due"), std::string::npos);
    EXPECT_NE(second(test_frame(scene, 1, {})).find("colour is of another size or kind"), std::string::npos);
    EXPECT_NE(second(test_frame(scene, 1, {true, true})).find("haptic is of another"), std::string::npos);
    EXPECT_NE(second(test_frame(small_scene(15, 16, 10), 1, {true})).find("of another size"),
              std::string::npos);
    EXPECT_NE(
        second(test_frame(small_scene(16, 16, 12), 1, {true})).find("depth.bits, 10, allows at most 1023"),
        std::string::npos);
    EXPECT_TRUE(is_refused(write_clip(folder / "clip.mkv", small_scene(0, 16), 1, {}), "width"));
    Scene fast = scene;
    fast.rate = {1001, 1};
    EXPECT_TRUE(is_refused(write_clip(folder / "clip.mkv", fast, 1, {}), "1001/1"));
    EXPECT_EQ(folder.file_count(), 0U);
}

}  // namespace
}  // namespace touchable::test
