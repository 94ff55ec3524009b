#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/clip/clip_fixture.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/sweep.hpp"

/// iPhone's Cinematic videos: FFmpeg writes two tracks of HEVC, and the second is marked as the phone marks
/// its disparity, handler `auxv` and sample entry `dish`.
namespace touchable::test {
namespace {

constexpr int disparity_width = 64, disparity_height = 36;

int disparity_at(int x, int y, int n) {
    return 40 + 2 * x + 3 * (y / 4) + n;
}

/// Packets of both, one after the other.
void write_cinematic(const std::filesystem::path& file) {
    const TemporaryFolder folder;
    ForeignVideo colour{"libx265", AV_PIX_FMT_YUV420P, 128, 72, 4};
    write_video(folder / "c.mov", colour, [](AVFrame& frame, int n) {
        for (int plane = 0; plane < 3; ++plane)
            for (int y = 0; y < 72 / (plane ? 2 : 1); ++y)
                for (int x = 0; x < 128 / (plane ? 2 : 1); ++x)
                    set_sample(frame, plane, x, y, plane ? 90 + x : 60 + x + n);
    });
    ForeignVideo depth{"libx265", AV_PIX_FMT_YUV420P, disparity_width, disparity_height, 4};
    depth.range = AVCOL_RANGE_JPEG;
    write_video(folder / "d.mov", depth, [](AVFrame& frame, int n) {
        for (int plane = 0; plane < 3; ++plane)
            for (int y = 0; y < disparity_height / (plane ? 2 : 1); ++y)
                for (int x = 0; x < disparity_width / (plane ? 2 : 1); ++x)
                    set_sample(frame, plane, x, y, plane ? 128 : disparity_at(x, y, n));
    });
    join_tracks({folder / "c.mov", folder / "d.mov"}, file);
    if (::testing::Test::HasFatalFailure()) return;
    std::string bytes = read_bytes(file);
    const auto entry = bytes.rfind("hvc1"), handler = bytes.rfind("mhlrvide");
    ASSERT_NE(entry, std::string::npos);
    ASSERT_NE(handler, std::string::npos);
    bytes.replace(entry, 4, "dish");
    bytes.replace(handler, 8, "mhlrauxv");
    write_bytes(file, bytes);
}

TEST(Cinematic, DisparityIsDepthAndTheFilmIsItsColour) {
    const TemporaryFolder folder;
    write_cinematic(folder / "IMG_0001.MOV");
    if (HasFatalFailure()) return;
    auto clip = open_clip(folder / "IMG_0001.MOV", {}, {}, Colour::wanted, DepthAlignment::off);
    ASSERT_EQ(message(clip), "");
    const Scene& scene = (*clip)->scene();
    EXPECT_EQ(scene.width, disparity_width);
    EXPECT_EQ(scene.height, disparity_height);
    EXPECT_EQ(scene.depth.kind, DepthCodingKind::inverse);
    EXPECT_TRUE(scene.depth.near_is_high);
    EXPECT_TRUE(is_noted(**clip, "depth is the disparity of a Cinematic video, colour is its other track"));
    EXPECT_TRUE(is_noted(**clip, "its nearest is taken for 0.5 m and its farthest for 1.5 m"));
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 4U);
    for (int n = 0; n < 4; ++n) {
        const RawFrame& frame = (*frames)[static_cast<std::size_t>(n)];
        ASSERT_EQ(frame.colour.width, disparity_width);
        for (int y = 0; y < disparity_height; ++y)
            for (int x = 0; x < disparity_width; ++x) {
                const int code = frame.depth.sample(x, y);
                ASSERT_EQ(code, disparity_at(x, y, n));
                const double z = 1 / (1 / 1.5 + (1 / 0.5 - 1 / 1.5) * code / 255.0);
                const auto point =
                    unproject(scene.camera, x, y, scene.depth.depth(static_cast<std::uint16_t>(code)));
                ASSERT_NEAR(point.x, (x - scene.camera.cx) / scene.camera.fx * z, 1e-9);
                ASSERT_NEAR(point.y, -(y - scene.camera.cy) / scene.camera.fy * z, 1e-9);
                ASSERT_NEAR(point.z, -z, 1e-9);
            }
    }
}

TEST(Cinematic, AFileThatIsCutIsToldAsAnyOther) {
    const TemporaryFolder folder;
    write_cinematic(folder / "a.mov");
    if (HasFatalFailure()) return;
    const std::string whole = read_bytes(folder / "a.mov");
    for (std::size_t length = 9; length < whole.size(); length += whole.size() / 40) {
        write_bytes(folder / "a.mov", whole.substr(0, length));
        EXPECT_FALSE(open_clip(folder / "a.mov")) << length;
    }
    // The name alone, in a track that is none: it is refused, and does not crash.
    for (std::size_t at = whole.find("moov"); at + 8 < whole.size(); at += 37 * sweep_step()) {
        std::string damaged = whole;
        damaged.replace(at, 4, "dish");
        write_bytes(folder / "a.mov", damaged);
        if (const auto clip = open_clip(folder / "a.mov"); clip) (void)(*clip)->next();
    }
}

}  // namespace
}  // namespace touchable::test
