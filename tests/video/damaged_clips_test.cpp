// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>
#include <unistd.h>

#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limits.hpp"
#include "tests/picture/picture_bytes.hpp"
#include "tests/sweep.hpp"
#include "tests/video/mp4_boxes.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

/// A clip's content, or the error of reading it.
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
        write_anew(folder / "damaged.mkv", damaged);
        return outcome_of(folder / "damaged.mkv");
    }
    TemporaryFolder folder;
    std::string bytes;
    Outcome whole;
};

TEST(ClipDamage, TruncationLeavesFirstFrames) {
    const Subject subject(8, 3, 16);
    for (std::size_t length = 0; length < subject.bytes.size(); length += sweep_step()) {
        const Outcome cut = subject.with(subject.bytes.substr(0, length));
        ASSERT_TRUE(!cut.error.empty() || begins_as(subject.whole, cut))
            << length << " of " << subject.bytes.size();
        ASSERT_TRUE(cut.error.empty() || cut.error.find("damaged.mkv: ") != std::string::npos) << cut.error;
    }
    EXPECT_TRUE(
        has_words(subject.with(subject.bytes.substr(0, subject.bytes.size() / 2)).error, "is truncated"));
    EXPECT_TRUE(has_words(subject.with("").error, "is empty"));
}

/// Each cluster has a few frames.
TEST(ClipDamage, CutEndsWithLastCluster) {
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
        auto reader = must(open_clip(subject.folder / "damaged.mkv"));
        EXPECT_EQ(reader->frame_count(), std::optional(static_cast<std::int64_t>(frames)));
        const auto& notes = reader->notes();
        const std::string note = "the file is cut: its first " + std::to_string(frames) + " frames are whole";
        EXPECT_EQ(std::count(notes.begin(), notes.end(), note), frames < 12 ? 1 : 0) << share;
        for (const std::size_t frame : {frames - 1, std::size_t{0}, frames / 2}) {
            ASSERT_EQ(message(reader->seek(static_cast<std::int64_t>(frame))), "");
            const RawFrame there = next_of(*reader);
            EXPECT_TRUE(same_frame(there, subject.whole.frames[frame])) << share << ": " << frame;
        }
    }
}

/// As a copy that is still under way leaves it.
TEST(ClipDamage, NamesTruncationAtEveryPercentage) {
    const TemporaryFolder folder;
    const ClipStorage in_fragments{.archive = Archive::fast, .exact_colour = true, .fragmented = true};
    for (const auto& [name, storage] :
         {std::pair{"a.mkv", exact_clip}, {"a.mp4", exact_clip}, {"b.mp4", in_fragments}})
        for (const Planes& planes : {Planes{}, Planes{true, true, false, false}}) {
            const std::string file = folder / name;
            ASSERT_EQ(message(write_clip(file, small_scene(64, 48, 16), 12, planes, storage)), "");
            const std::string bytes = read_bytes(file);
            const bool is_mkv = file.ends_with("mkv");
            int refused = 0;
            for (std::size_t share = 1; share < 100; ++share) {
                write_anew(file, bytes.substr(0, bytes.size() * share / 100));
                const auto frames = read_clip(file);
                if (frames) continue;
                ++refused;
                const std::string said = message(frames);
                EXPECT_TRUE(said.ends_with("is truncated: it ends before its first whole frame") ||
                            (!is_mkv && said.ends_with("is truncated, or no QuickTime or MP4 file")))
                    << share << " %: " << said;
            }
            EXPECT_GT(refused, 0);
        }
}

/// As a writer that was stopped leaves it: the segment's size and the duration not filled in.
TEST(ClipDamage, NamesIncompleteClip) {
    const Subject subject(8, 3, 16);
    const std::string segment("\x18\x53\x80\x67", 4);
    std::string live = subject.bytes;
    const auto at = live.find(segment);
    ASSERT_NE(at, std::string::npos);
    live.replace(at + 4, 8, "\x01\xff\xff\xff\xff\xff\xff\xff");
    EXPECT_TRUE(has_words(subject.with(live).error, "was never completed"));
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

TEST(ClipDamage, FindsEveryHarmfulByte) {
    constexpr Planes depth_and_haptic{false, true};  // all tracks are alike, and FFmpeg opens H.264 slowly
    expect_every_change_is_found(Subject(8, 2, 12, depth_and_haptic));
}

TEST(ClipDamage, FindsHarmfulBytesOfSmall) {
    const Subject subject(8, 2, 12, all_planes, {Archive::small, true});
    auto reader = must(open_clip(subject.folder / "whole.mkv"));
    const char* expected[] = {"t3d2", "ffv1", "ffv1", "ffv1"};
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(reader->tracks()[k].codec, expected[k]);
    expect_every_change_is_found(subject);
}

TEST(ClipDamage, NamesTrackAndFrame) {
    const Subject subject(40, 3, 10);
    const std::vector<std::string> payloads = packets(subject.folder / "whole.mkv");
    ASSERT_EQ(payloads.size(), 12U);
    const char* roles[] = {"depth", "colour", "haptic", "height"};
    Random numbers(5);
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
std::string scattered(std::string bytes, std::size_t begin, std::size_t end, Random& numbers) {
    for (int k = numbers.below(30); k >= 0; --k)
        bytes[begin + static_cast<std::size_t>(numbers.below(static_cast<int>(end - begin)))] =
            static_cast<char>(numbers.below(256));
    return bytes;
}

TEST(ClipDamage, FindsHeavyDamageAmongFrames) {
    const Subject subject(24, 3, 16);
    const auto clusters = subject.bytes.find("\x1F\x43\xB6\x75"),
               cues = subject.bytes.rfind("\x1C\x53\xBB\x6B");
    ASSERT_LT(clusters, cues);
    ASSERT_NE(cues, std::string::npos);
    Random numbers(7);
    for (int trial = 0; trial < 500; ++trial) {
        const Outcome outcome = subject.with(scattered(subject.bytes, clusters, cues, numbers));
        ASSERT_TRUE(!outcome.error.empty() || same_outcome(outcome, subject.whole)) << "trial " << trial;
    }
}

/// Files of other writers may carry no checksums for what is not payload. Damage there may pass, but not
/// crash: tests/fuzz.
TEST(ClipDamage, ReadsClipWithoutChecksums) {
    const Subject subject(24, 3, 16);
    remux(subject.folder / "whole.mkv", subject.folder / "bare.mkv", {.checksums = false});
    const std::string bytes = read_bytes(subject.folder / "bare.mkv");
    EXPECT_TRUE(same_outcome(subject.with(bytes), subject.whole));
}

/// Other programs keep no additions to packets. FFV1 has checksums of its own; depth's codec here has none.
TEST(ClipDamage, ChecksSlicesWithoutAdditions) {
    const Subject subject(8, 2, 12, all_planes, {Archive::small, true});
    remux(subject.folder / "whole.mkv", subject.folder / "bare.mkv", {.checksums = false});
    std::string bytes = read_bytes(subject.folder / "bare.mkv");
    std::size_t at = 0;
    for (int n = 0; (at = bytes.find("\x75\xA1\x8F", at)) != std::string::npos; ++n, ++at)
        if (n % 4 != 0) bytes.replace(at, 2, "\xEC\x90");  // padding
    EXPECT_TRUE(same_outcome(subject.with(bytes), subject.whole));
    const std::string colour = packets(subject.folder / "whole.mkv").at(5);
    bytes.at(bytes.find(colour) + colour.size() / 2) ^= 1;
    EXPECT_TRUE(has_words(subject.with(bytes).error, "track colour, frame 1: is damaged: its checksum"));
}

TEST(ClipDamage, RejectsOtherFiles) {
    const TemporaryFolder folder;
    write_bytes(folder / "noise.mkv", std::string(5000, 'x'));
    EXPECT_TRUE(is_refused(open_clip(folder / "noise.mkv"), "is of no kind that is known"));
    EXPECT_TRUE(is_refused(open_clip(folder / "none.mkv"), "does not exist"));
    EXPECT_TRUE(is_refused(open_clip("/dev/null"), "is neither a file nor a folder"));
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_TRUE(is_refused(open_clip(folder / "pipe"), "but a pipe: read it as -, touchable play - < "));
}

/// Any user but root, for whom no file is closed.
class PlainUser {
public:
    PlainUser() { is_plain = geteuid() != 0 || seteuid(65534) == 0; }
    ~PlainUser() {
        EXPECT_TRUE(getuid() != 0 || seteuid(0) == 0);
    }
    bool is_plain = false;
};

TEST(OpenClip, NamesMissingPermission) {
    namespace fs = std::filesystem;
    const TemporaryFolder folder;
    const std::string secret = folder / "secret", outer = folder / "outer", file = folder / "file.mkv";
    const std::string inner = outer + "/depth", inside = secret + "/clip.mkv";
    fs::create_directories(secret);
    fs::create_directories(inner);
    write_bytes(file, "");
    write_bytes(inside, "");
    fs::permissions(folder.path(), fs::perms::all);
    const std::vector<std::string> closed{secret, inner, file};
    for (const std::string& each : closed) fs::permissions(each, fs::perms::none);
    {
        const PlainUser user;
        if (!user.is_plain) GTEST_SKIP() << "the system gives no other user";
        for (const std::string& each : {inside, secret, file})
            EXPECT_EQ(message(open_clip(each)), each + ": Permission denied");
        EXPECT_EQ(message(open_clip(outer)), inner + ": Permission denied");
    }
    for (const std::string& each : closed) fs::permissions(each, fs::perms::owner_all);
}

struct ClipWriting : ::testing::Test {
    const TemporaryFolder folder;
};

TEST_F(ClipWriting, LeavesNothingWithoutFinish) {
    const Scene scene = small_scene(16, 16);
    {
        auto writer = must(create_clip(folder / "clip.mkv", scene));
        ASSERT_EQ(message(writer->write(test_frame(scene, 0, {}))), "");
        EXPECT_FALSE(std::filesystem::exists(folder / "clip.mkv"));
    }
    EXPECT_EQ(folder.file_count(), 0U);
    {
        auto writer = must(create_clip(folder / "clip.mkv", scene));
        EXPECT_TRUE(is_refused(writer->finish(), "no frame was given"));
    }
    EXPECT_EQ(folder.file_count(), 0U);
}

TEST_F(ClipWriting, KeepsOlderFileUntilFinished) {
    const Scene scene = small_scene(16, 16);
    write_bytes(folder / "clip.mkv", "older");
    {
        auto writer = must(create_clip(folder / "clip.mkv", scene));
        ASSERT_EQ(message(writer->write(test_frame(scene, 0, {}))), "");
    }
    EXPECT_EQ(read_bytes(folder / "clip.mkv"), "older");
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 2, {})), "");
    EXPECT_EQ(message(read_clip(folder / "clip.mkv")), "");
    EXPECT_EQ(folder.file_count(), 1U);
}

TEST_F(ClipWriting, NamesUnwritablePlaces) {
    write_bytes(folder / "file", "x");
    for (const auto& path : {folder / "absent" / "clip.mkv", folder / "file" / "clip.mkv"}) {
        EXPECT_TRUE(is_refused(create_clip(path, small_scene(8, 8)),
                               path.string() + ": cannot be written: ", ErrorKind::input));
    }
    std::filesystem::create_directory(folder / "taken.mkv");
    for (const auto& [path, why] : {std::pair(folder / "taken.mkv", ": is a folder; name a file"),
                                    std::pair(std::filesystem::path("/dev/null"), ": is no regular file")})
        EXPECT_TRUE(is_refused(create_clip(path, small_scene(8, 8)), path.string() + why))
            << "before any frame";
    EXPECT_EQ(folder.file_count(), 2U);
}

TEST_F(ClipWriting, LeavesNothingOnFullDisk) {
    for (const rlim_t size : {1U, 1000U, 100'000U, 400'000U}) {
        const FullDisk full(size);
        const auto result = write_clip(folder / "clip.mkv", small_scene(128, 128, 16), 20, all_planes);
        ASSERT_FALSE(result) << size;
        EXPECT_TRUE(is_refused(result, "clip.mkv: cannot be written: "));
        EXPECT_EQ(folder.file_count(), 0U);
    }
}

TEST_F(ClipWriting, RejectsForeignFrames) {
    const Scene scene = small_scene(16, 16, 10);
    const auto second = [&](const RawFrame& frame) {
        auto writer = create_clip(folder / "clip.mkv", scene);
        EXPECT_EQ(message((*writer)->write(test_frame(scene, 0, {true}))), "");
        const std::string error = message((*writer)->write(frame));
        EXPECT_NE(message((*writer)->finish()), "");  // a clip that lacks a frame is not given its name
        return error;
    };
    EXPECT_TRUE(has_words(second(test_frame(scene, 2, {true})), "number 1 was due"));
    EXPECT_TRUE(has_words(second(test_frame(scene, 1, {})), "colour is of another size or kind"));
    EXPECT_TRUE(has_words(second(test_frame(scene, 1, {true, true})), "haptic is of another"));
    EXPECT_TRUE(has_words(second(test_frame(small_scene(15, 16, 10), 1, {true})), "of another size"));
    EXPECT_TRUE(has_words(second(test_frame(small_scene(16, 16, 12), 1, {true})),
                          "depth.bits, 10, allows at most 1023"));
    EXPECT_TRUE(is_refused(write_clip(folder / "clip.mkv", small_scene(0, 16), 1, {}), "width"));
    Scene fast = scene;
    fast.rate = {1001, 1};
    EXPECT_TRUE(is_refused(write_clip(folder / "clip.mkv", fast, 1, {}), "1001/1"));
    EXPECT_EQ(folder.file_count(), 0U);
}

/// The error of reading a clip that was remuxed with changes.
std::string refusal(const Remux& changes) {
    const TemporaryFolder folder;
    EXPECT_EQ(message(write_clip(folder / "good.mkv", small_scene(64, 48, 16), 5, {true, true, true, false})),
              "");
    remux(folder / "good.mkv", folder / "clip.mkv", changes);
    const auto frames = read_clip(folder / "clip.mkv");
    if (frames) return "";
    EXPECT_EQ(frames.error().kind, ErrorKind::input);
    EXPECT_TRUE(is_refused(frames, "clip.mkv: "));
    EXPECT_EQ(frames.error().message.find('\n'), std::string::npos);
    return frames.error().message;
}

#define EXPECT_REFUSED(changes, part) EXPECT_TRUE(has_words(refusal(changes), part))

struct ClipRefusal : ::testing::Test {
    const TemporaryFolder folder;
};

TEST_F(ClipRefusal, ChecksVersion) {
    const std::pair<const char*, const char*> faults[] = {
        {"3", "is of clip format 3; this program reads up to 2"},
        {"", "is not a touchable clip"},
        {"0", "T3D_VERSION is \"0\""},
        {"1x", "T3D_VERSION is \"1x\""}};
    for (const auto& [version, words] : faults)
        EXPECT_REFUSED(Remux({.file_tags = {{"T3D_VERSION", version}}}), words);
    EXPECT_EQ(refusal({.file_tags = {{"T3D_VERSION", "1"}}}), "");
    EXPECT_EQ(refusal({}), "");
}

TEST_F(ClipRefusal, ChecksRate) {
    const std::pair<const char*, const char*> faults[] = {
        {"", "T3D_RATE is missing"},
        {"30", "T3D_RATE is \"30\""},
        {"30/0", "T3D_RATE is \"30/0\""},
        {"-30/1", "T3D_RATE is \"-30/1\""},
        {"25/1", "T3D_RATE is 25/1, but its scene.json says 30/1"}};
    for (const auto& [rate, words] : faults)
        EXPECT_REFUSED(Remux({.file_tags = {{"T3D_RATE", rate}}}), words);
    EXPECT_EQ(refusal({.file_tags = {{"T3D_RATE", "60/2"}}}), "");
}

TEST_F(ClipRefusal, ChecksRolesAndFormats) {
    const std::pair<Remux, const char*> faults[] = {
        {{.attachment_name = "notes.txt"}, "has no scene.json attached: describe it with a scene file"},
        {{.roles = {{"height", "warmth"}}}, "track 4 has the role \"warmth\""},
        {{.roles = {{"haptic", "colour"}}}, "track 3 is a second track of role colour"},
        {{.roles = {{"depth", ""}}}, "has no track of role depth"},
        {{.roles = {{"depth", ""}, {"colour", "depth"}}},
         "track depth, frame 0: is 8-bit RGB, but the scene's depth.bits, 16, needs 16-bit grey"},
        {{.roles = {{"depth", ""}, {"height", "depth"}}}, "needs 16-bit grey"},
        {{.roles = {{"depth", "height"}, {"height", "depth"}}}, "track depth, frame 0: is 8-bit grey"},
        {{.roles = {{"height", ""}, {"colour", "height"}}}, "track height, frame 0: has pixel format gbrp"},
        {{.transcoded = {{"haptic", "mjpeg"}}}, "track haptic, frame 0: has pixel format yuvj420p"}};
    for (const auto& [changes, words] : faults) EXPECT_REFUSED(changes, words);
}

TEST_F(ClipRefusal, NamesMissingFrame) {
    const auto without = [](const std::string& role, int number) {
        return Remux({.drop = [=](const std::string& r, int n) { return r == role && n == number; }});
    };
    for (const char* role : {"depth", "colour", "haptic", "height"}) {
        const std::string track = std::string("track ") + role;
        EXPECT_REFUSED(without(role, 2), track + ", frame 2: is missing");
        EXPECT_REFUSED(without(role, 4), track + ", frame 4: is missing");
    }
    EXPECT_REFUSED(without("colour", 0), "track colour, frame 0: is missing");
    EXPECT_REFUSED(Remux({.drop = [](const std::string&, int n) { return n == 2; }}),
                   "track depth, frame 2: is missing");
}

TEST_F(ClipRefusal, NamesDepthOfAnotherSize) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 2, {})), "");
    EXPECT_TRUE(is_refused(open_as(folder / "clip.mkv", small_scene(41, 30)),
                           "track depth, frame 0: is 40x30, but the scene is 41x30"));
}

TEST_F(ClipRefusal, NamesValuesBeyondSceneBits) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30, 16), 2, {})), "");
    EXPECT_TRUE(is_refused(open_as(folder / "clip.mkv", small_scene(40, 30, 12)), "allows at most 4095"));
}

TEST_F(ClipRefusal, ChecksBitsOfHeights) {
    Scene scene = small_scene(40, 30);
    ASSERT_EQ(message(write_clip(folder / "narrow.mkv", scene, 2, {false, false, true})), "");
    scene.height_coding.code_max = 65535;
    ASSERT_EQ(message(write_clip(folder / "wide.mkv", scene, 2, {false, false, true})), "");
    EXPECT_TRUE(
        is_refused(open_as(folder / "narrow.mkv", scene),
                   "track height, frame 0: is 8-bit grey, but the scene's height_map.bits needs 16-bit"));
    scene.height_coding.code_max = 1023;
    EXPECT_TRUE(is_refused(open_as(folder / "wide.mkv", scene), "allows at most 1023"));
}

TEST_F(ClipRefusal, NamesUnreadableSceneFile) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 2, {})), "");
    EXPECT_TRUE(is_refused(open_clip(folder / "clip.mkv", folder / "absent.json"), "absent.json"));
    write_bytes(folder / "scene.json", "{}");
    EXPECT_TRUE(is_refused(open_clip(folder / "clip.mkv", folder / "scene.json"), "scene.json"));
}

/// The codec that is our own stands on what the container says.
TEST_F(ClipRefusal, ChecksOwnCodec) {
    ASSERT_EQ(message(write_clip(folder / "good.mkv", small_scene(64, 48, 16), 2, {})), "");
    remux(folder / "good.mkv", folder / "bare.mkv", {.checksums = false});
    const std::string good = read_bytes(folder / "bare.mkv");
    const auto refusal_with = [&](const std::string& part, const std::string& other) {
        std::string bytes = good;
        const auto at = bytes.find(part);
        EXPECT_NE(at, std::string::npos) << part;
        bytes.replace(at, other.size(), other);
        write_bytes(folder / "clip.mkv", bytes);
        return message(read_clip(folder / "clip.mkv"));
    };
    EXPECT_EQ(refusal_with("T3D2", "T3D2"), "");
    EXPECT_TRUE(has_words(refusal_with("T3D2", "T3D3"), "track depth: has codec T3D3: must be one of ffv1,"));
    EXPECT_TRUE(has_words(refusal_with("T3D_BITS", "T3D_BYTE"), "track depth: its tag T3D_BITS is missing"));
    EXPECT_TRUE(has_words(refusal_with("\xB0\x81\x40", "\xB0\x81\x3F"), "track depth, frame 0: is damaged"));
    // FFmpeg 7 refuses such a width before we look at it.
    const std::string no_width = refusal_with("\xB0\x81\x40", std::string("\xB0\x81\0", 3));
    EXPECT_TRUE(has_words(no_width, "track depth: its header is damaged: it says 0x48 pixels") ||
                has_words(no_width, "is not a readable Matroska file"))
        << no_width;
    // An addition of another number is none of ours. (Its 13 bytes begin with the number, as FFmpeg 7 has a
    // like number in the track.)
    EXPECT_TRUE(has_words(refusal_with("\xA6\x8D\xEE\x81\x01", "\xA6\x8D\xEE\x81\x02"),
                          "track depth, frame 0: is damaged: its checksum is missing or wrong"));
    // The additions of frame 0, 15 bytes and their size, become padding.
    EXPECT_TRUE(has_words(refusal_with("\x75\xA1\x8F", "\xEC\x90"),
                          "track depth, frame 0: is damaged: its checksum is missing"));
}

constexpr std::uint64_t gibibyte = std::uint64_t{1} << 30;

/// A file of this beginning, and from there holes up to `size` bytes.
std::filesystem::path sparse(const TemporaryFolder& folder, const std::string& begin, std::uint64_t size) {
    write_bytes(folder / "large", begin);
    std::filesystem::resize_file(folder / "large", size);
    return folder / "large";
}

/// The error of opening a file in little memory.
std::string refusal_in(const std::filesystem::path& file, rlim_t mebibytes) {
    const LimitedMemory little(mebibytes);
    return message(open_clip(file));
}

/// An element's size in eight bytes.
std::string element(const std::string& id, std::uint64_t size) {
    return id + '\1' + big_endian(size, 7);
}
const std::string segment_id = "\x18\x53\x80\x67", head = "\x1a\x45\xdf\xa3\x80";

struct HostileFile : ::testing::Test {
    const TemporaryFolder folder;
};

TEST_F(HostileFile, LocatesElementBeyondItsSegment) {
    const std::string clip = head + segment_id + '\x81' + element("\x81", 8 * gibibyte);
    ASSERT_EQ(clip.size(), 19U);
    write_bytes(folder / "clip.mkv", clip);
    EXPECT_TRUE(has_words(refusal_in(folder / "clip.mkv", 256), "is damaged near byte 10"));
}

TEST_F(HostileFile, IsNotReadWhole) {
    const auto of_one = [&](const std::string& id) {
        const std::string begin =
            head + element(segment_id, 5 * gibibyte + id.size() + 8) + element(id, 5 * gibibyte);
        return refusal_in(sparse(folder, begin, begin.size() + 5 * gibibyte), 256);
    };
    EXPECT_TRUE(has_words(of_one("\xec"), "is not a ")) << "padding alone: not a clip, or no Matroska";
    EXPECT_TRUE(has_words(of_one("\x19\x41\xa4\x69"), "larger than 64 MiB together"));
}

TEST_F(HostileFile, RejectsHugeJpeg) {
    EXPECT_TRUE(
        has_words(refusal_in(sparse(folder, "\xff\xd8\xff\xe1", 5 * gibibyte), 256), "larger than 257 MiB"));
    EXPECT_TRUE(is_refused(read_image(folder / "large"), "larger than 257 MiB"));
}

TEST_F(HostileFile, BoundsPictureSize) {
    const std::string head_of_floats = "Pf\n8192 8192\n-1.0\n";
    const std::uint64_t values = std::uint64_t{4} * 8192 * 8192;
    const auto floats = read_picture_bytes(sparse(folder, head_of_floats, head_of_floats.size() + values));
    EXPECT_EQ(message(floats), "");
    const std::uint64_t most = std::uint64_t{257} << 20U;
    EXPECT_EQ(message(read_picture_bytes(sparse(folder, head_of_floats, most))), "");
    EXPECT_EQ(message(read_picture_bytes(sparse(folder, head_of_floats, most + 1))),
              (folder / "large").string() + ": is larger than 257 MiB; expected a picture");
}

TEST_F(HostileFile, RejectsPipesAsScenes) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 1, {})), "");
    ASSERT_EQ(mkfifo((folder / "pipe.json").c_str(), 0600), 0);
    alarm(30);  // a reader waits for ever for a writer
    const std::pair<std::filesystem::path, std::string> kinds[] = {
        {folder / "pipe.json", "is a pipe, no ordinary file"},
        {folder / "absent.json", "does not exist"},
        {folder.path(), "is a folder"},
        {"/dev/zero", "is a device, no ordinary file"}};
    for (const auto& [file, kind] : kinds)
        EXPECT_EQ(message(open_clip(folder / "clip.mkv", file)),
                  file.string() + ": " + kind + "; expected a scene file (JSON, docs/scene_file.md)");
    alarm(0);
}

TEST_F(HostileFile, RejectsUnneededCodecs) {
    ASSERT_EQ(message(write_clip(folder / "good.mkv", small_scene(64, 48), 2, {true})), "");
    remux(folder / "good.mkv", folder / "clip.mkv", {.transcoded = {{"colour", "msmpeg4v2"}}});
    EXPECT_TRUE(is_refused(open_clip(folder / "clip.mkv"),
                           "track colour: has codec msmpeg4v2: must be one of ffv1,"));
}

TEST_F(HostileFile, IsQuotedShortly) {
    ASSERT_EQ(message(write_clip(folder / "good.mkv", small_scene(16, 16), 1, {})), "");
    const std::string tag = "1\n\x1b[31m" + std::string(100'000, 'x');
    remux(folder / "good.mkv", folder / "clip.mkv", {.file_tags = {{"T3D_RATE", tag}}});
    const std::string refusal = message(open_clip(folder / "clip.mkv"));
    EXPECT_TRUE(has_words(refusal, "is \"1\\n\\x1b[31mxxx"));
    EXPECT_LT(refusal.size(), 300U);
}

// MP4 clips that are cut or changed: an error of one line, or frames; of those that are cut, all or none.

/// A clip as bytes, and a place for damaged copies.
struct Mp4Subject {
    Mp4Subject() {
        EXPECT_EQ(message(write_clip(folder / "whole.mp4", scene, frames, planes)), "");
        bytes = read_bytes(folder / "whole.mp4");
    }
    /// Nothing where it opened and was read to its end; otherwise the error, of one line.
    std::string error_of(const std::string& damaged) {
        write_anew(folder / "damaged.mp4", damaged);
        const auto read = read_clip(folder / "damaged.mp4");
        if (read) {
            EXPECT_FALSE(read->empty());
            EXPECT_LE(read->size(), static_cast<std::size_t>(frames));
            return "";
        }
        EXPECT_TRUE(is_one_line_about(folder / "damaged.mp4", read));
        EXPECT_EQ(read.error().kind, ErrorKind::input) << read.error().message;
        return read.error().message;
    }
    static constexpr int frames = 2;
    static constexpr Planes planes{false, true};
    TemporaryFolder folder;
    Scene scene = small_scene(8, 8, 12);
    std::string bytes;
};

TEST(Mp4Damage, RejectsCutFile) {
    Mp4Subject subject;
    EXPECT_EQ(subject.error_of(subject.bytes), "");
    for (std::size_t length = 0; length < subject.bytes.size(); length += sweep_step())
        EXPECT_NE(subject.error_of(subject.bytes.substr(0, length)), "") << length;
}

TEST(Mp4Damage, SurvivesChangedMovieBox) {
    Mp4Subject subject;
    const FoundBox movie = boxes_of(subject.bytes).back();
    int refused = 0;
    for (const int change : {0x01, 0x80, 0xFF})
        for (std::size_t at = movie.at + static_cast<std::size_t>(change % 3); at < movie.end;
             at += 3 * sweep_step()) {
            std::string damaged = subject.bytes;
            damaged[at] = static_cast<char>(damaged[at] ^ change);
            refused += subject.error_of(damaged).empty() ? 0 : 1;
        }
    EXPECT_GT(refused, 100);
}

TEST(Mp4Damage, SurvivesChangedScene) {
    Mp4Subject subject;
    const auto boxes = boxes_of(subject.bytes);
    const FoundBox& scene = boxes[boxes.size() - 2];
    int refused = 0, tried = 0;
    for (std::size_t at = scene.at; at < scene.end; at += sweep_step()) {
        std::string damaged = subject.bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
        refused += subject.error_of(damaged).empty() ? 0 : 1;
        ++tried;
    }
    EXPECT_GT(4 * refused, tried);
}

}  // namespace
}  // namespace touchable::test
