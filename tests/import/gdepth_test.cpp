#include <gtest/gtest.h>

#include <cmath>

#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/jpeg_with_xmp.hpp"
#include "tests/picture/encoded_picture.hpp"
#include "tests/real_data.hpp"

namespace touchable::test {
namespace {

constexpr int deep_photo_wide = 12, deep_photo_high = 10;

std::uint8_t depth_at(int x, int y) {
    return static_cast<std::uint8_t>(20 * x + 3 * y);
}

/// A depth map as phones store it: three channels alike, and alpha.
std::string depth_png(int odd_one_out = -1) {
    return encoded("png", AV_PIX_FMT_RGBA, deep_photo_wide, deep_photo_high, [&](AVFrame& frame) {
        for (int y = 0; y < deep_photo_high; ++y)
            for (int x = 0; x < deep_photo_wide; ++x) {
                std::uint8_t* pixel =
                    frame.data[0] + std::ptrdiff_t{frame.linesize[0]} * y + 4 * std::ptrdiff_t{x};
                pixel[0] = pixel[1] = pixel[2] = depth_at(x, y);
                pixel[3] = 255;
                if (y * deep_photo_wide + x == odd_one_out) ++pixel[1];
            }
    });
}

/// A plain picture; half the depth map's size where asked.
std::string plain_jpeg(int divisor = 1) {
    return encoded("mjpeg", AV_PIX_FMT_YUVJ420P, deep_photo_wide / divisor, deep_photo_high / divisor,
                   [&](AVFrame& frame) {
                       for (int plane = 0; plane < 3; ++plane)
                           for (int y = 0; y < (plane == 0 ? frame.height : (frame.height + 1) / 2); ++y)
                               for (int x = 0; x < (plane == 0 ? frame.width : (frame.width + 1) / 2); ++x)
                                   frame.data[plane][y * frame.linesize[plane] + x] = plane == 0   ? 150
                                                                                      : plane == 1 ? 100
                                                                                                   : 140;
                   });
}

struct Gdepth {
    std::string attributes =
        "GDepth:Format='RangeInverse' GDepth:Near='2' GDepth:Far='10' GDepth:Mime='image/png'";
    std::string data = encode_base64(depth_png());
    std::string picture = plain_jpeg();
    std::size_t piece = 300;  ///< bytes of the extended packet in each segment

    std::string file() const {
        const std::string extended = "<x><rdf:Description GDepth:Data=\"" + data + "\"/></x>";
        std::string segments = xmp_segment("<x><rdf:Description xmpNote:HasExtendedXMP='" +
                                           std::string(guid) + "' " + attributes + "/></x>");
        for (std::size_t from = 0; from < extended.size(); from += piece)
            segments += extension_segment(guid, extended, from, std::min(from + piece, extended.size()));
        return picture.substr(0, 2) + segments + picture.substr(2);
    }
};

Result<std::unique_ptr<ClipReader>> open_bytes(const TemporaryFolder& folder, const std::string& bytes) {
    write_bytes(folder / "still.jpg", bytes);
    return open_clip(folder / "still.jpg");
}

TEST(GdepthJpeg, IsAClipOfOneFrame) {
    const TemporaryFolder folder;
    auto clip = open_bytes(folder, Gdepth().file());
    ASSERT_EQ(message(clip), "");
    const Scene& scene = (*clip)->scene();
    EXPECT_EQ(scene.name, "still");
    EXPECT_EQ(scene.width, deep_photo_wide);
    EXPECT_EQ(scene.height, deep_photo_high);
    EXPECT_EQ(scene.metres_per_unit, 1.0);
    EXPECT_EQ(scene.camera.cx, 5.5);
    EXPECT_EQ(scene.camera.cy, 4.5);
    EXPECT_EQ(scene.camera.fx, scene.camera.fy);
    EXPECT_NEAR(2 * std::atan(deep_photo_wide / 2.0 / scene.camera.fx) * 180 / M_PI, 60, 1e-12);
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::planar);
    for (int v = 0; v < 256; ++v)  // as the format's description has it
        EXPECT_NEAR(scene.depth.depth(static_cast<std::uint16_t>(v)), 10.0 * 2 / (10 - v / 255.0 * (10 - 2)),
                    1e-12);
    EXPECT_TRUE(is_noted(**clip, "guessed: lengths are metres"));
    EXPECT_TRUE(is_noted(**clip,
                         "guessed: the camera sees 60 degrees from left to right; if it sees 70, all shapes "
                         "are 18 % too narrow (a scene file"));
    EXPECT_FALSE(is_noted(**clip, "resampled"));
    EXPECT_EQ((*clip)->frame_count(), 1);
    ASSERT_EQ((*clip)->tracks().size(), 2U);
    EXPECT_EQ((*clip)->tracks()[0].pixel_format, "rgba");
    for (int round = 0; round < 2; ++round) {
        const auto frames = read_all(**clip);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 1U);
        const RawFrame& frame = frames->front();
        EXPECT_EQ(frame.time_ns, 0);
        ASSERT_EQ(frame.depth.channels, 1);
        for (int y = 0; y < deep_photo_high; ++y)
            for (int x = 0; x < deep_photo_wide; ++x) {
                ASSERT_EQ(frame.depth.sample(x, y), depth_at(x, y));
                ASSERT_EQ(frame.colour.sample(x, y, 0), frame.colour.sample(0, 0, 0));
            }
        EXPECT_GT(frame.colour.sample(0, 0, 0), frame.colour.sample(0, 0, 2));  // more red than blue
        ASSERT_EQ(message((*clip)->rewind()), "");
    }
}

TEST(GdepthJpeg, SaysWhatItsDepthsMean) {
    const TemporaryFolder folder;
    Gdepth still;
    still.attributes =
        "GDepth:Format='RangeLinear' GDepth:Near='200' GDepth:Far='1220' GDepth:Units='mm' "
        "GDepth:MeasureType='OpticRay'";
    auto clip = open_bytes(folder, still.file());
    ASSERT_EQ(message(clip), "");
    const Scene& scene = (*clip)->scene();
    EXPECT_EQ(scene.metres_per_unit, 0.001);
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::range);
    for (int v = 0; v < 256; ++v)
        EXPECT_DOUBLE_EQ(scene.depth.depth(static_cast<std::uint16_t>(v)), 200.0 + 4 * v);
    EXPECT_FALSE(is_noted(**clip, "metres"));
}

TEST(GdepthJpeg, DepthMayBeOfSixteenBits) {
    const TemporaryFolder folder;
    Samples memory;
    const PlaneView plane = test_plane(memory, deep_photo_wide, deep_photo_high, 2, 1, 65535, 3, true);
    ASSERT_EQ(message(write_png(folder / "depth.png", plane)), "");
    Gdepth still;
    still.data = encode_base64(read_bytes(folder / "depth.png"));
    auto clip = open_bytes(folder, still.file());
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->scene().depth.code_max, 65535);
    const auto frames = read_all(**clip);
    EXPECT_TRUE(same_plane(frames->front().depth, plane));
}

TEST(GdepthJpeg, APictureOfAnotherSizeIsResampledAndSaysSo) {
    const TemporaryFolder folder;
    Gdepth still;
    still.picture = plain_jpeg(2);
    auto clip = open_bytes(folder, still.file());
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "colour is 6x5: resampled"));
    EXPECT_EQ((*read_all(**clip)).front().colour.width, deep_photo_wide);
}

TEST(GdepthJpeg, ASceneFileReplacesWhatIsAssumed) {
    const TemporaryFolder folder;
    Scene scene = small_scene(deep_photo_wide, deep_photo_high);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 3;
    scene.depth.near = 0;
    scene.depth.far = 3 * 255;
    SceneDescription without_far(scene);
    without_far.unstated.far = true;
    write_bytes(folder / "scene.json", scene_to_json(without_far));
    write_bytes(folder / "still.jpg", Gdepth().file());
    auto clip = open_clip(folder / "still.jpg", folder / "scene.json");
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->scene().name, "small");
    EXPECT_FALSE(is_noted(**clip, "guessed"));
    const double deepest = 3.0 * depth_at(deep_photo_wide - 1, deep_photo_high - 1);
    EXPECT_DOUBLE_EQ((*clip)->scene().depth.far, 1.05 * deepest);
}

TEST(GdepthJpeg, LeavesNothingToGuess) {
    const TemporaryFolder folder;
    write_bytes(folder / "portrait.jpg", Gdepth().file());
    EXPECT_TRUE(is_refused(guess_clip(folder / "portrait.jpg", {}), "touchable convert "));
    write_bytes(folder / "plain.jpg", plain_jpeg());
    EXPECT_TRUE(is_refused(guess_clip(folder / "plain.jpg", {}), "is in colour"));
}

TEST(GdepthJpeg, WhatIsMissingOrWrongIsSaid) {
    const TemporaryFolder folder;
    const auto with = [](const std::string& attributes) {
        Gdepth still;
        still.attributes = attributes;
        return still.file();
    };
    const auto with_data = [](const std::string& data) {
        Gdepth still;
        still.data = data;
        return still.file();
    };
    const std::string ends = "GDepth:Near='2' GDepth:Far='10'";
    const std::pair<std::string, const char*> cases[] = {
        {plain_jpeg(), "has no GDepth:Data in its XMP"},
        {with(ends), "has no GDepth:Format"},
        {with("GDepth:Format='Disparity' " + ends), "GDepth:Format is \"Disparity\": must be RangeInverse"},
        {with("GDepth:Format='RangeInverse' GDepth:Far='10'"), "has no GDepth:Near"},
        {with("GDepth:Format='RangeInverse' GDepth:Near='2'"), "has no GDepth:Far"},
        {with("GDepth:Format='RangeInverse' GDepth:Near='2m' GDepth:Far='10'"), "GDepth:Near is \"2m\""},
        {with("GDepth:Format='RangeInverse' GDepth:Near='2' GDepth:Far='inf'"), "GDepth:Far is \"inf\""},
        {with("GDepth:Format='RangeInverse' GDepth:Near='20' GDepth:Far='10'"), "depth.near is 20"},
        {with("GDepth:Format='RangeInverse' GDepth:Near='0' GDepth:Far='10'"), "depth.near is 0"},
        {with("GDepth:Format='RangeInverse' GDepth:Units='ft' " + ends), "GDepth:Units is \"ft\""},
        {with("GDepth:Format='RangeInverse' GDepth:MeasureType='x' " + ends), "GDepth:MeasureType is \"x\""},
        {with_data("?" + encode_base64(depth_png())), "GDepth:Data is not base64"},
        {with_data(""), "depth: is neither PNG nor JPEG"},
        {with_data(encode_base64("GIF89a")), "depth: is neither PNG nor JPEG"},
        {with_data(encode_base64(depth_png().substr(0, 60))), "depth: is cut short"},
        {with_data(encode_base64(depth_png(77))), "its depth map is coloured"},
    };
    for (const auto& [bytes, word] : cases) {
        const auto clip = open_bytes(folder, bytes);
        ASSERT_FALSE(clip) << word;
        EXPECT_EQ(clip.error().kind, ErrorKind::input);
        EXPECT_TRUE(message(clip).starts_with((folder / "still.jpg").string() + ": ")) << message(clip);
        EXPECT_NE(message(clip).find(word), std::string::npos) << word << " in: " << message(clip);
    }
}

struct Still {
    const char* name;
    int width, height;
    double near, far;
};

class RealGdepth : public ::testing::TestWithParam<Still> {};

TEST_P(RealGdepth, HasItsFormsDepthsInMetres) {
    const auto file = real_data("stills/lensblur") / (std::string(GetParam().name) + ".jpg");
    TOUCHABLE_NEEDS_DATA(file);
    auto clip = open_clip(file);
    ASSERT_EQ(message(clip), "");
    const Scene& scene = (*clip)->scene();
    EXPECT_EQ(scene.width, GetParam().width);
    EXPECT_EQ(scene.height, GetParam().height);
    EXPECT_NEAR(scene.depth.near, GetParam().near, 0.001);
    EXPECT_NEAR(scene.depth.far, GetParam().far, 0.001);
    EXPECT_EQ(scene.depth.depth(0), scene.depth.near);
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    const RawFrame& frame = frames->front();
    // A figure in the middle stands before a background at the top.
    const auto depth = [&](int x, int y) { return scene.depth.depth(frame.depth.sample(x, y)); };
    const double figure = depth(scene.width / 2, scene.height / 2), background = depth(scene.width / 2, 10);
    EXPECT_LT(figure * 1.3, background);
    EXPECT_EQ(frame.colour.width, scene.width);
}

INSTANTIATE_TEST_SUITE_P(Lensblur, RealGdepth,
                         ::testing::Values(Still{"greek-helmet", 2048, 1536, 4.484, 19.309},
                                           Still{"yamasa-maneki-neko", 1536, 2048, 8.291, 40.795}),
                         [](const auto& test) { return test.index == 0 ? "Helmet" : "Neko"; });

}  // namespace
}  // namespace touchable::test
