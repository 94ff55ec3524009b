#include <gtest/gtest.h>

#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/clip_remux.hpp"

namespace touchable::test {
namespace {

bool has_note(const std::vector<std::string>& notes, const std::string& part) {
    for (const std::string& note : notes)
        if (note.find(part) != std::string::npos) return true;
    return false;
}

TEST(ClipNotes, TouchThatIsStoredWithLossIsSaid) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "exact.mkv", small_scene(64, 48), 2, {true})), "");
    EXPECT_FALSE(has_note((*open_clip(folder / "exact.mkv"))->notes(), "stored as"));
    for (const char* role : {"depth", "colour"}) {
        remux(folder / "exact.mkv", folder / "lossy.mkv", {.transcoded = {{role, "mjpeg"}}});
        const auto reader = open_clip(folder / "lossy.mkv");
        ASSERT_EQ(message(reader), "");
        EXPECT_EQ(has_note((*reader)->notes(), "depth is stored as mjpeg, which changes values"),
                  role == std::string("depth"));
    }
}

TEST(ClipNotes, AFrameWithoutAnyDepthIsSaid) {
    const TemporaryFolder folder;
    const Planes ramp{.noisy = false};  // from 4 on
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 2, ramp)), "");
    EXPECT_FALSE(has_note((*open_clip(folder / "clip.mkv"))->notes(), "no valid depth"));
    Scene scene = small_scene(40, 30);
    scene.depth.code_max = 3;
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const auto reader = open_clip(folder / "clip.mkv", folder / "scene.json");
    ASSERT_EQ(message(reader), "");
    EXPECT_TRUE(has_note((*reader)->notes(), "frame 0 has no valid depth"));
}

/// What opening says of a clip of so many bits with a scene that speaks of 16.
std::string of_bits(int bits, DepthCodingKind kind) {
    const TemporaryFolder folder;
    EXPECT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30, bits), 1, {})), "");
    EXPECT_EQ(message(open_clip(folder / "clip.mkv")), "");
    Scene scene = small_scene(40, 30, 16);
    scene.depth.kind = kind;
    scene.depth.scale = 0.01;
    write_bytes(folder / "scene.json", scene_to_json(scene));
    return message(open_clip(folder / "clip.mkv", folder / "scene.json"));
}

TEST(ClipNotes, ATrackHasTheBitsThatTheSceneSpeaksOf) {
    const auto refused = [](int bits, const std::string& as) {
        for (const auto kind : {DepthCodingKind::linear, DepthCodingKind::inverse})
            EXPECT_NE(of_bits(bits, kind).find("track depth, frame 0: is " + as), std::string::npos)
                << of_bits(bits, kind);
        EXPECT_EQ(of_bits(bits, DepthCodingKind::metric), "");  // lengths, whatever holds them
    };
    refused(10, "10-bit grey, but the scene's depth.code_max is 65535: must be at most 1023");
    refused(12, "12-bit grey, but the scene's depth.code_max is 65535: must be at most 4095");
    EXPECT_EQ(of_bits(14, DepthCodingKind::metric), "");
}

}  // namespace
}  // namespace touchable::test
