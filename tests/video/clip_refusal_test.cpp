#include <gtest/gtest.h>

#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/clip_remux.hpp"

namespace touchable::test {
namespace {

/// The error of reading a clip that was remuxed with changes.
std::string refusal(const Remux& changes) {
    const TemporaryFolder folder;
    EXPECT_EQ(message(write_clip(folder / "good.mkv", small_scene(64, 48, 16), 5, {true, true, true, false})),
              "");
    remux(folder / "good.mkv", folder / "clip.mkv", changes);
    const auto frames = read_clip(folder / "clip.mkv");
    if (frames) return "";
    EXPECT_EQ(frames.error().kind, ErrorKind::input);
    EXPECT_NE(frames.error().message.find("clip.mkv: "), std::string::npos);
    EXPECT_EQ(frames.error().message.find('\n'), std::string::npos);
    return frames.error().message;
}

#define EXPECT_REFUSED(changes, part) EXPECT_PRED2(contains, refusal(changes), part)
bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(ClipRefusal, RemuxingWithoutChangesIsReadable) {
    EXPECT_EQ(refusal({}), "");
}

TEST(ClipRefusal, VersionMustBeOneThisProgramReads) {
    EXPECT_REFUSED(Remux({.file_tags = {{"T3D_VERSION", "3"}}}),
                   "is of clip format 3; this program reads up to 2");
    EXPECT_EQ(refusal({.file_tags = {{"T3D_VERSION", "1"}}}), "");
    EXPECT_REFUSED(Remux({.file_tags = {{"T3D_VERSION", ""}}}), "is not a touchable clip");
    EXPECT_REFUSED(Remux({.file_tags = {{"T3D_VERSION", "0"}}}), "T3D_VERSION is \"0\"");
    EXPECT_REFUSED(Remux({.file_tags = {{"T3D_VERSION", "1x"}}}), "T3D_VERSION is \"1x\"");
}

TEST(ClipRefusal, RateMustBeTheScenes) {
    EXPECT_REFUSED(Remux({.file_tags = {{"T3D_RATE", ""}}}), "T3D_RATE is missing");
    EXPECT_REFUSED(Remux({.file_tags = {{"T3D_RATE", "30"}}}), "T3D_RATE is \"30\"");
    EXPECT_REFUSED(Remux({.file_tags = {{"T3D_RATE", "30/0"}}}), "T3D_RATE is \"30/0\"");
    EXPECT_REFUSED(Remux({.file_tags = {{"T3D_RATE", "-30/1"}}}), "T3D_RATE is \"-30/1\"");
    EXPECT_REFUSED(Remux({.file_tags = {{"T3D_RATE", "25/1"}}}),
                   "T3D_RATE is 25/1, but its scene.json says 30/1");
    EXPECT_EQ(refusal({.file_tags = {{"T3D_RATE", "60/2"}}}), "");
}

TEST(ClipRefusal, RolesMustBeKnownAndSingle) {
    EXPECT_REFUSED(Remux({.roles = {{"height", "warmth"}}}), "track 4 has the role \"warmth\"");
    EXPECT_REFUSED(Remux({.roles = {{"haptic", "colour"}}}), "track 3 is a second track of role colour");
    EXPECT_REFUSED(Remux({.roles = {{"depth", ""}}}), "has no track of role depth");
}

TEST(ClipRefusal, RolesMustFitWhatIsStored) {
    EXPECT_REFUSED(Remux({.roles = {{"depth", ""}, {"colour", "depth"}}}),
                   "track depth, frame 0: is 8-bit RGB, but the scene's depth.bits, 16, needs 16-bit grey");
    EXPECT_REFUSED(Remux({.roles = {{"depth", ""}, {"height", "depth"}}}), "needs 16-bit grey");
    EXPECT_REFUSED(Remux({.roles = {{"depth", "height"}, {"height", "depth"}}}),
                   "track depth, frame 0: is 8-bit grey");
    EXPECT_REFUSED(Remux({.roles = {{"height", ""}, {"colour", "height"}}}),
                   "track height, frame 0: has pixel format gbrp");
}

TEST(ClipRefusal, ASceneIsNeeded) {
    EXPECT_REFUSED(Remux({.attachment_name = "notes.txt"}),
                   "has no scene.json attached: describe it with a scene file");
}

TEST(ClipRefusal, HapticMustNotBeSubsampled) {
    EXPECT_REFUSED(Remux({.transcoded = {{"haptic", "mjpeg"}}}),
                   "track haptic, frame 0: has pixel format yuvj420p");
}

TEST(ClipRefusal, EveryTrackHasEveryFrame) {
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

TEST(ClipRefusal, DepthOfAnotherSizeThanTheSceneIsNamed) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 2, {})), "");
    write_bytes(folder / "scene.json", scene_to_json(small_scene(41, 30)));
    const auto reader = open_clip(folder / "clip.mkv", folder / "scene.json");
    EXPECT_PRED2(contains, message(reader), "track depth, frame 0: is 40x30, but the scene is 41x30");
}

TEST(ClipRefusal, ValuesBeyondTheScenesBitsAreNamed) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30, 16), 2, {})), "");
    write_bytes(folder / "scene.json", scene_to_json(small_scene(40, 30, 12)));
    const auto reader = open_clip(folder / "clip.mkv", folder / "scene.json");
    EXPECT_PRED2(contains, message(reader), "allows at most 4095");
}

TEST(ClipRefusal, HeightsMustBeOfTheScenesBits) {
    const TemporaryFolder folder;
    Scene scene = small_scene(40, 30);
    ASSERT_EQ(message(write_clip(folder / "narrow.mkv", scene, 2, {false, false, true})), "");
    scene.height_coding.code_max = 65535;
    ASSERT_EQ(message(write_clip(folder / "wide.mkv", scene, 2, {false, false, true})), "");
    write_bytes(folder / "wide.json", scene_to_json(scene));
    const std::string narrow = message(open_clip(folder / "narrow.mkv", folder / "wide.json"));
    EXPECT_PRED2(contains, narrow,
                 "track height, frame 0: is 8-bit grey, but the scene's height_map.bits needs 16-bit");
    scene.height_coding.code_max = 1023;
    write_bytes(folder / "ten.json", scene_to_json(scene));
    EXPECT_PRED2(contains, message(open_clip(folder / "wide.mkv", folder / "ten.json")),
                 "allows at most 1023");
}

TEST(ClipRefusal, UnreadableSceneFilesAreNamed) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 2, {})), "");
    EXPECT_PRED2(contains, message(open_clip(folder / "clip.mkv", folder / "absent.json")), "absent.json");
    write_bytes(folder / "scene.json", "{}");
    EXPECT_PRED2(contains, message(open_clip(folder / "clip.mkv", folder / "scene.json")), "scene.json");
}

/// The codec that is our own stands on what the container says.
TEST(ClipRefusal, OwnCodecNeedsItsBitsItsSizeAndItsChecksums) {
    const TemporaryFolder folder;
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
    EXPECT_PRED2(contains, refusal_with("T3D2", "T3D3"), "track depth: has codec T3D3: must be one of ffv1,");
    EXPECT_PRED2(contains, refusal_with("T3D_BITS", "T3D_BYTE"), "track depth: its tag T3D_BITS is missing");
    EXPECT_PRED2(contains, refusal_with("\xB0\x81\x40", "\xB0\x81\x3F"), "track depth, frame 0: is damaged");
    // FFmpeg 7 refuses such a width before we look at it.
    const std::string no_width = refusal_with("\xB0\x81\x40", std::string("\xB0\x81\0", 3));
    EXPECT_TRUE(contains(no_width, "track depth: its header is damaged: it says 0x48 pixels") ||
                contains(no_width, "is not a readable Matroska file"))
        << no_width;
    // The additions of frame 0, 15 bytes and their size, become padding.
    EXPECT_PRED2(contains, refusal_with("\x75\xA1\x8F", "\xEC\x90"),
                 "track depth, frame 0: is damaged: its checksum is missing");
}

}  // namespace
}  // namespace touchable::test
