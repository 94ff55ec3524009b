// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/formats/formats_read.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/picture/results.hpp"
#include "tests/real_data.hpp"

namespace touchable::test {
namespace {

using Rgb = std::array<int, 3>;

/// A colour of full saturation; `code` from 0 to 1535.
Rgb of_hue(int code) {
    const int sector = code / 256, f = code % 256, up = f * 255 / 256, down = 255 - up;
    constexpr int m = 0, M = 255;
    const Rgb sectors[] = {{M, up, m}, {down, M, m}, {m, M, up}, {m, down, M}, {up, m, M}, {M, m, down}};
    return sectors[sector];
}

/// Packed RGB without loss.
template <class Colour>
void write_rgb(const std::filesystem::path& file, int width, int height, Colour&& colour) {
    ForeignVideo video{"png", AV_PIX_FMT_RGB24, width, height};
    video.frames = 2;
    write_video(file, video, [&](AVFrame& frame, int) { fill_rgb(frame, colour); });
}

void write_grey(const std::filesystem::path& file, const char* codec = "ffv1",
                AVPixelFormat format = AV_PIX_FMT_GRAY8, int most = 255) {
    write_video(file, {codec, format}, [&](AVFrame& frame, int n) {
        fill_plane(frame, 0, [&](int x, int y) { return std::min(most, (most / 64) * (x + 2 * y + n)); });
        for (int plane = 1; plane < 3 && frame.data[plane]; ++plane)
            fill_plane(frame, plane, [&](int, int) { return 128; });
    });
}

using GuessedVideo = FolderTest;

TEST_F(GuessedVideo, TakesGreyAsRelativeDepth) {
    for (const AVPixelFormat format : {AV_PIX_FMT_GRAY8, AV_PIX_FMT_GRAY10LE}) {
        const int most = format == AV_PIX_FMT_GRAY8 ? 255 : 1023;
        write_grey(folder / "d.mkv", "ffv1", format, most);
        auto clip = must(open_clip(folder / "d.mkv"));
        const Scene& scene = clip->scene();
        EXPECT_EQ(scene.name, "d");
        EXPECT_EQ(scene.depth.kind, DepthCodingKind::inverse);
        EXPECT_TRUE(scene.depth.near_is_high);  // brighter below
        EXPECT_NEAR(scene.depth.depth(0), 1.5, 1e-12);
        EXPECT_NEAR(scene.depth.depth(static_cast<std::uint16_t>(most)), 0.5, 1e-12);
        EXPECT_NEAR(scene.camera.fx, 16 / std::tan(M_PI / 6), 1e-12);
        EXPECT_TRUE(is_noted(*clip, "guessed: depth is grey and has no colour beside it"));
        EXPECT_TRUE(is_noted(*clip, "sees 60 degrees"));
        EXPECT_TRUE(is_noted(*clip, "its nearest is taken for 0.5 m and its farthest for 1.5 m"));
        EXPECT_EQ(read_all(*clip)->size(), 3U);
    }
}

TEST_F(GuessedVideo, TakesSixteenBitsAsMillimetres) {
    write_grey(folder / "d.mkv", "ffv1", AV_PIX_FMT_GRAY16LE, 3000);
    auto clip = must(open_clip(folder / "d.mkv"));
    EXPECT_EQ(clip->scene().depth.depth(1000), 1);
    EXPECT_TRUE(is_noted(*clip, "depth codes are millimetres"));
    SourceDescription known;
    known.intrinsics = Intrinsics{.fx = 30, .fy = 31};
    known.metres_per_code = 0.0005;
    clip = must(open_clip(folder / "d.mkv", {}, known));
    EXPECT_EQ(clip->scene().depth.depth(1000), 0.5);
    EXPECT_EQ(clip->scene().camera.fy, 31);
}

TEST_F(GuessedVideo, ReadsLossyGrey) {
    for (const auto& [codec, name, is_lossy] : {std::tuple{"mpeg4", "d.mp4", true},
                                                {"mpeg4", "d.avi", true},
                                                {"libx264", "d.mp4", false},
                                                {"libx264", "d.mkv", false},
                                                {"libx265", "d.mp4", false},
                                                {"libvpx-vp9", "d.webm", true}}) {
        if (!can_encode(codec)) continue;
        write_grey(folder / name, codec, AV_PIX_FMT_YUV420P);
        auto clip = open_clip(folder / name);
        ASSERT_EQ(message(clip), "") << codec;
        EXPECT_TRUE(is_noted(**clip, "depth is grey")) << codec;
        EXPECT_EQ(is_noted(**clip, "which changes values"), is_lossy) << codec;
        EXPECT_EQ((*clip)->tracks().front().lossless, !is_lossy) << codec;
        const auto frames = read_all(**clip);
        ASSERT_EQ(message(frames), "") << codec;
        ASSERT_EQ(frames->size(), 3U);
        for (int n = 0; n < 3; ++n)
            for (int y = 0; y < 16; ++y)
                for (int x = 0; x < 32; ++x)
                    ASSERT_NEAR((*frames)[static_cast<std::size_t>(n)].depth.sample(x, y),
                                std::min(255, 3 * (x + 2 * y + n)), std::string(codec) == "mpeg4" ? 12 : 0)
                        << codec << " " << x << "," << y << " of frame " << n;
    }
}

TEST_F(GuessedVideo, ReadsHueAsDepth) {
    const auto code = [](int x, int y) { return 40 * x + 10 * y; };
    write_rgb(folder / "d.mov", 32, 16, [&](int x, int y) { return of_hue(code(x, y)); });
    auto clip = must(open_clip(folder / "d.mov"));
    const Scene& scene = clip->scene();
    EXPECT_EQ(scene.depth.kind, DepthCodingKind::hue);
    EXPECT_TRUE(is_noted(*clip, "guessed: red is 0.5 m"));
    const auto frames = must(read_all(*clip));
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 32; ++x)
            EXPECT_NEAR(stored_code(frames[1].depth, scene.depth, x, y), code(x, y), 2);
}

TEST_F(GuessedVideo, RecognisesRecord3dByItsCamera) {
    const auto code = [](int x, int y) { return 256 + 30 * x + 10 * y; };
    write_rgb(folder / "d.mp4", 64, 16, [&](int x, int y) {
        return x < 32 ? of_hue(code(x, y)) : Rgb{10 * y, 90, 200};
    });
    const std::string video = read_bytes(folder / "d.mp4");
    for (const char* matrix : {"[40.5,0,0,0,41.5,0,15.25,8.5,1]", "[40.5,0,15.25,0,41.5,8.5,0,0,1]"}) {
        write_bytes(folder / "d.mp4",
                    video + R"({"intrinsicMatrix":)" + matrix + R"(,"rangeOfEncodedDepth":[0,3]})");
        auto clip = must(open_clip(folder / "d.mp4"));
        const Scene& scene = clip->scene();
        EXPECT_EQ(scene.camera, (Camera{40.5, 41.5, 15.25, 8.5}));
        EXPECT_TRUE(is_noted(*clip, "as Record3D exports it"));
        const auto frames = must(read_all(*clip));
        ASSERT_EQ(frames.size(), 2U);
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 32; ++x) {
                EXPECT_NEAR(stored_code(frames[0].depth, scene.depth, x, y), code(x, y), 2);
                EXPECT_EQ(frames[0].colour.sample(x, y, 0), 10 * y);
            }
    }
    for (std::size_t length = video.size() - 40; length < video.size(); length += 3) {
        write_bytes(folder / "d.mp4", video.substr(0, length));
        EXPECT_TRUE(is_refused(open_clip(folder / "d.mp4"), "is truncated"));
    }
}

TEST_F(GuessedVideo, RefusesColourAlone) {
    write_rgb(folder / "d.mov", 32, 16, [](int x, int y) { return Rgb{90 + 3 * x, 120, 60 + 4 * y}; });
    const std::string said = message(open_clip(folder / "d.mov"));
    EXPECT_TRUE(has_words(said, "no depth was found: frame 0, 32x16, has no grey half"));
    EXPECT_TRUE(has_words(said, "touchable play SCENE.json"));
    for (const char* name : {"take.r3d", "TAKE.R3D"}) {
        write_bytes(folder / name, std::string("PK\3\4 and more", 13));
        EXPECT_TRUE(is_refused(open_clip(folder / name), "which its app exports as EXR + RGB"));
    }
}

/// Against an unprojection written out here: hues from 0.5 to 1.5 m, 60 degrees wide.
TEST_F(GuessedVideo, FindsHueBesideColour) {
    const auto code = [](int x, int y) { return 100 + 40 * x + 10 * y; };
    write_rgb(folder / "d.mov", 64, 16, [&](int x, int y) {
        return x < 32 ? Rgb{120 + 2 * x, 110, 90 + 4 * y} : of_hue(code(x - 32, y));
    });
    auto clip = must(open_clip(folder / "d.mov"));
    EXPECT_TRUE(is_noted(*clip, "depth is the right half, which is hue, colour the left one"));
    const auto frames = must(read_all(*clip));
    const Scene& scene = clip->scene();
    const RawFrame& frame = frames.front();
    const double f = 16 / std::tan(M_PI / 6);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 32; ++x) {
            const double z = 0.5 + code(x, y) / 1536.0, near = 0.003;
            EXPECT_TRUE(
                is_at(scene, stored_code(frame.depth, scene.depth, x, y), {f, f, 15.5, 7.5}, x, y, z, near));
            EXPECT_EQ(frame.colour.sample(x, y, 2), 90 + 4 * y);
        }
}

/// Grey with a tint, as chroma of lossy videos has it; and what a person says stands against what is seen.
TEST_F(GuessedVideo, TellsRampFromHue) {
    // Black, blue, cyan, white: each channel is filled before the next one.
    const auto level = [](int x, int y) { return 60 + 18 * x + 4 * y; };
    write_rgb(folder / "d.mov", 32, 16, [&](int x, int y) {
        const auto part = [&](int from) { return std::clamp(level(x, y) - from, 0, 255); };
        return Rgb{part(510), part(255), part(0)};
    });
    auto clip = must(open_clip(folder / "d.mov"));
    EXPECT_TRUE(is_noted(*clip, "depth is a ramp from black through colours to white"));
    const auto frame = must(clip->next());
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 32; ++x)
            ASSERT_EQ((*frame).depth.sample(x, y), (level(x, y) + 1) / 3) << x << ',' << y;
    // Full hues from red to yellow beside pixels without depth are no ramp.
    write_rgb(folder / "hue.mov", 32, 16, [&](int x, int y) {
        return x < 8 ? Rgb{0, 0, 0} : of_hue(10 + 6 * x + 2 * y);
    });
    clip = must(open_clip(folder / "hue.mov"));
    EXPECT_EQ(clip->scene().depth.kind, DepthCodingKind::hue);
}

TEST_F(GuessedVideo, AveragesNearlyGrey) {
    const auto tinted = [](int x, int y) {
        const int grey = 40 + 5 * x + 2 * y;
        return Rgb{grey + 15, grey, grey - 15};
    };
    write_rgb(folder / "tinted.mov", 32, 16, tinted);
    const auto coloured = [](int x, int y) { return Rgb{90 + 3 * x, 120, 60 + 4 * y}; };
    write_rgb(folder / "coloured.mov", 32, 16, coloured);
    SourceDescription mean, hue;
    mean.preset = "mean";
    hue.preset = "hue";
    const auto expect_mean = [&](const char* name, const SourceDescription& known, const auto& colour) {
        auto clip = open_clip(folder / name, std::nullopt, known);
        ASSERT_EQ(message(clip), "") << name;
        EXPECT_TRUE(is_noted(**clip, "a value is the mean of its colours"));
        const auto frame = must((*clip)->next());
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 32; ++x) {
                const Rgb rgb = colour(x, y);
                ASSERT_EQ((*frame).depth.sample(x, y), (rgb[0] + rgb[1] + rgb[2] + 1) / 3) << x << ',' << y;
            }
    };
    expect_mean("tinted.mov", {}, tinted);
    expect_mean("coloured.mov", mean, coloured);
    for (const char* name : {"tinted.mov", "coloured.mov"}) {
        const auto clip = must(open_clip(folder / name, std::nullopt, hue));
        EXPECT_EQ(clip->scene().depth.kind, DepthCodingKind::hue);
    }
    write_grey(folder / "grey.mkv");
    EXPECT_TRUE(is_refused(open_clip(folder / "grey.mkv", std::nullopt, hue), "has no colours"));
    Samples memory;
    ASSERT_EQ(message(write_png(folder / "a.png", test_plane(memory, 20, 10, 2, 1, 3000, 5, true))), "");
    EXPECT_TRUE(is_refused(open_clip(folder / "a.png", std::nullopt, mean), "preset mean is for depth videos"));
}

/// Depth beside colour, and the camera behind the film.
void write_record3d(const std::filesystem::path& file, const std::function<Rgb(int, int)>& depth) {
    write_rgb(file, 64, 16, [&](int x, int y) { return x < 32 ? depth(x, y) : Rgb{10 * y, 90, 200}; });
    write_bytes(file, read_bytes(file) + R"({"intrinsicMatrix":[40.5,0,0,0,41.5,0,15.25,8.5,1]})");
}

TEST_F(GuessedVideo, ReadsGreyHalfOfRecord3d) {
    write_record3d(folder / "d.mp4", [](int x, int) { return Rgb{50 + 4 * x, 50 + 4 * x, 50 + 4 * x}; });
    const auto clip = must(open_clip(folder / "d.mp4"));
    EXPECT_EQ(clip->scene().camera.fx, 40.5);
    EXPECT_EQ(clip->scene().depth.kind, DepthCodingKind::inverse);
    EXPECT_TRUE(is_noted(*clip, "depth is the left half, which is grey"));
}

TEST_F(GuessedVideo, TakesDarkHalfOfRecord3dAsGrey) {
    const auto kind_of = [&](const std::function<Rgb(int, int)>& depth) {
        write_record3d(folder / "d.mp4", depth);
        return must(open_clip(folder / "d.mp4"))->scene().depth.kind;
    };
    // Eight codes of grey; noise of some 20 codes, by which few pixels are lit, and these vivid.
    EXPECT_NE(kind_of([](int x, int y) {
                  return Rgb{(x + y) / 6, (x + y) / 6, (x + y) / 6};
              }),
              DepthCodingKind::hue);
    EXPECT_NE(kind_of([](int x, int y) {
                  const auto noise = [&](int c) { return 10 + (x * 7 + y * 5 + c * 11) % 21; };
                  return Rgb{x % 16 == 3 ? 55 : noise(0), noise(1), x % 16 == 3 ? 10 : noise(2)};
              }),
              DepthCodingKind::hue);
    EXPECT_EQ(kind_of([](int, int) { return Rgb{0, 0, 0}; }), DepthCodingKind::hue) << "no evidence";
    EXPECT_EQ(kind_of([](int x, int y) {
                  return x == 9 ? of_hue(40 * y) : Rgb{0, 0, 0};
              }),
              DepthCodingKind::hue)
        << "little before black";
}

TEST_F(GuessedVideo, TakesDullHalfOfRecord3dAsMean) {
    // Bluish grey, up to 49 codes from grey: hues would all be one blue.
    const auto grey = [](int x, int y) { return 40 + 5 * x + 3 * y; };
    write_record3d(folder / "d.mp4", [&](int x, int y) {
        const int blue = grey(x, y), other = blue * 4 / 5;
        return Rgb{other, other, blue};
    });
    auto clip = must(open_clip(folder / "d.mp4"));
    EXPECT_EQ(clip->scene().depth.kind, DepthCodingKind::inverse);
    EXPECT_TRUE(is_noted(*clip, "depth is the left half, which is nearly grey"));
    const auto frame = must(clip->next());
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 32; ++x) {
            const int blue = grey(x, y), other = blue * 4 / 5;
            ASSERT_EQ((*frame).depth.sample(x, y), (2 * other + blue + 1) / 3) << x << ',' << y;
        }
}

TEST_F(GuessedVideo, RefusesHueOfGrey) {
    for (const int tint : {0, 3, 12}) {
        write_rgb(folder / "d.mov", 32, 16, [&](int x, int y) {
            const int grey = 20 + 5 * x + 3 * y;
            return Rgb{grey + tint * (x % 2), grey, grey + tint * (y % 2)};
        });
        EXPECT_TRUE(is_refused(open_clip(folder / "d.mov", {}, stated(&SourceDescription::preset, "hue")),
                               "is grey in three channels"));
        auto clip = must(open_clip(folder / "d.mov"));
        EXPECT_TRUE(is_noted(*clip, "depth is grey"));
        EXPECT_EQ((*must(clip->next())).depth.sample(7, 5), 70 + (2 * tint + 1) / 3);
    }
}

TEST_F(GuessedVideo, ReadsGreyThatGetsTinted) {
    ForeignVideo video{"png", AV_PIX_FMT_RGB24, 32, 16};
    video.frames = 2;
    write_video(folder / "d.mov", video, [&](AVFrame& frame, int n) {
        fill_rgb(frame, [&](int x, int y) {
            const int grey = 20 + 5 * x + 3 * y;
            return Rgb{grey, grey, grey + 6 * n};
        });
    });
    auto clip = must(open_clip(folder / "d.mov", {}, stated(&SourceDescription::metres_per_code, 0.01)));
    const auto frames = must(read_all(*clip));
    EXPECT_EQ(frames[0].depth.sample(4, 2), 46);
    EXPECT_EQ(frames[1].depth.sample(4, 2), 48);
}

TEST_F(GuessedVideo, MeanOfBlackIsNoDepth) {
    // A disc before black that a codec moved by up to three codes.
    write_rgb(folder / "d.mov", 32, 16, [](int x, int y) {
        const int noise = (x * 7 + y * 5) % 4, grey = 150 + 2 * x + y;
        const bool is_disc = (x - 16) * (x - 16) + (y - 8) * (y - 8) < 36;
        return is_disc ? Rgb{grey + 30, grey, grey - 30} : Rgb{noise, noise, noise};
    });
    SourceDescription mean;
    mean.preset = "mean";
    const auto expect_invalid = [&](const SourceDescription& known) {
        const auto clip = must(open_clip(folder / "d.mov", {}, known));
        const DepthCoding& depth = clip->scene().depth;
        for (std::uint16_t code = 0; code < 4; ++code) EXPECT_FALSE(depth.is_valid(code)) << code;
        EXPECT_TRUE(depth.is_valid(4));
        return depth;
    };
    EXPECT_EQ(expect_invalid(mean).kind, DepthCodingKind::inverse);
    mean.metres_per_code = 0.01;
    EXPECT_DOUBLE_EQ(expect_invalid(mean).nearest_depth(), 0.04);
}

/// As Depth Anything writes them: the picture, 50 white columns, its depth.
TEST_F(GuessedVideo, SkipsBarBetweenHalves) {
    const auto pixel = [](int x, int y) {
        return x < 90     ? Rgb{200, 2 * x, 5 * y}
               : x >= 140 ? Rgb{2 * (x - 140), 2 * (x - 140), 2 * (x - 140)}
                          : Rgb{255, 255, 255};
    };
    write_rgb(folder / "d.mov", 230, 24, pixel);
    auto clip = must(open_clip(folder / "d.mov"));
    EXPECT_TRUE(is_noted(*clip, "50 columns between them are of neither"));
    const auto frames = must(read_all(*clip));
    const PlaneView &depth = frames.front().depth, &colour = frames.front().colour;
    ASSERT_EQ(depth.width, 90);
    ASSERT_EQ(colour.width, 90);
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 90; ++x) {
            EXPECT_EQ(depth.sample(x, y), 2 * x);
            EXPECT_EQ(colour.sample(x, y, 1), 2 * x);
        }
    // The scene that is guessed says so by its width.
    const auto guessed = guess_video(folder / "d.mov", {});
    write_bytes(folder / "scene.json", scene_to_json(*guessed));
    auto described = must(open_clip(folder / "scene.json"));
    const auto same = read_all(*described);
    EXPECT_TRUE(same_frame(same->back(), frames.back()));
}

TEST_F(GuessedVideo, FindsColourVideoByName) {
    for (const auto& [depth, colour] : {std::pair{"walk_depth.mkv", "walk.mov"},
                                        {"walk_vis.mkv", "walk_src.mov"},
                                        {"depth.mkv", "rgb.mov"}}) {
        const TemporaryFolder fresh;
        write_grey(fresh / depth);
        write_bytes(fresh / "walk_rgb.mov", "no video");
        write_rgb(fresh / colour, 32, 16, [](int x, int y) { return Rgb{7 * x, 9 * y, 40}; });
        auto clip = must(open_clip(fresh / depth));
        EXPECT_TRUE(is_noted(*clip, std::string("colour is ") + colour)) << depth;
        const auto frames = must(read_all(*clip));
        EXPECT_EQ(frames.front().colour.sample(3, 2, 0), 21);
    }
}

TEST_F(GuessedVideo, OpensByItsGuessedScene) {
    write_grey(folder / "grey.mkv");
    write_grey(folder / "deep.mkv", "ffv1", AV_PIX_FMT_GRAY12LE, 3000);
    write_rgb(folder / "hue.mov", 32, 16, [](int x, int y) { return of_hue(40 * x + 10 * y); });
    write_rgb(folder / "halves.mov", 32, 16, [](int x, int y) {
        return x >= 16 ? Rgb{9 * y, 9 * y, 9 * y} : Rgb{200, 10 * y, 30};
    });
    for (const char* name : {"grey.mkv", "deep.mkv", "hue.mov", "halves.mov"}) {
        const auto guessed = guess_video(folder / name, {});
        ASSERT_EQ(message(guessed), "") << name;
        write_bytes(folder / "scene.json", scene_to_json(*guessed));
        auto described = open_clip(folder / "scene.json"),
             again = open_clip(folder / name, folder / "scene.json");
        ASSERT_EQ(message(described), "") << name;
        ASSERT_EQ(message(again), "") << name;
        auto bare = open_clip(folder / name);
        EXPECT_EQ((*described)->scene().depth, (*bare)->scene().depth) << name;
        const auto frames = read_all(**bare), same = read_all(**described), third = read_all(**again);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(same->size(), frames->size());
        EXPECT_TRUE(same_frame(same->back(), frames->back())) << name;
        EXPECT_TRUE(same_frame(third->back(), frames->back())) << name;
    }
}

constexpr int width = 8, height = 6;  // of each half

constexpr const char* metadata = R"(%YAML 1.1
--- !u!114 &11400000
MonoBehaviour:
  m_Name: Clip.Metadata
  depthkitMetadata:
    _versionMajor: 0
    format: perpixel
    textureWidth: 8
    textureHeight: 12
    boundsCenter: {x: 0, y: 0, z: 0.89}
    perspectives:
    - depthImageSize: {x: 8, y: 6}
      depthPrincipalPoint: {x: 3.75, y: 2.5}
      depthFocalLength: {x: 7.5, y: 7.25}
      farClip: 1.5
      nearClip: 0.5
      crop: {x: 0, y: 0, z: 1, w: 1}
)";

std::string with(const std::string& old_text, const std::string& new_text) {
    std::string text = metadata;
    const auto at = text.find(old_text);
    EXPECT_NE(at, std::string::npos) << old_text;
    return text.replace(at, old_text.size(), new_text);
}

std::vector<Image> noise(int frames, int image_width = width, int image_height = 2 * height) {
    Random numbers(5);
    std::vector<Image> pictures;
    for (int n = 0; n < frames; ++n)
        pictures.push_back(
            made_image(image_width, image_height, 1, 3, [&](int, int, int) { return numbers.below(256); }));
    return pictures;
}

void write_depthkit(const TemporaryFolder& folder, const std::vector<Image>& pictures,
                    const std::string& text = metadata, const FrameRate& rate = {24, 1}) {
    write_quicktime(folder / "Clip.mov", pictures, rate);
    write_bytes(folder / "Clip.Metadata.asset", text);
}

using Depthkit = FolderTest;

TEST_F(Depthkit, SplitsColourAboveDepth) {
    const auto pictures = noise(5);
    write_depthkit(folder, pictures, metadata, {30000, 1001});
    auto clip = must(open_clip(folder / "Clip.mov"));
    const Scene& scene = clip->scene();
    EXPECT_EQ(scene.name, "Clip");
    EXPECT_EQ(scene.width, width);
    EXPECT_EQ(scene.height, height);
    EXPECT_EQ(scene.rate.num, 30000);
    EXPECT_EQ(scene.rate.den, 1001);
    EXPECT_EQ(scene.metres_per_unit, 1.0);
    EXPECT_EQ(scene.camera, (Camera{7.5, 7.25, 3.75, 2.5}));
    EXPECT_EQ(scene.depth.kind, DepthCodingKind::hue);
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::planar);
    EXPECT_EQ(scene.depth.depth(0), 0.5);
    EXPECT_DOUBLE_EQ(scene.depth.depth(768), 1.0);  // half the circle, half the way
    // The last of 32 parts of the circle is red from the other side.
    EXPECT_TRUE(scene.depth.is_valid(1488));
    EXPECT_FALSE(scene.depth.is_valid(1489));
    EXPECT_DOUBLE_EQ(scene.depth.far, 0.5 + 31.0 / 32);
    EXPECT_EQ(scene.depth.least_sum, 77);
    EXPECT_EQ(scene.filter.median, 5) << "it sees beyond a compressed block of 4x4";
    EXPECT_EQ(scene.filter.fill_holes, 2);
    EXPECT_EQ(clip->frame_count(), 5);
    ASSERT_EQ(clip->tracks().size(), 2U);
    EXPECT_EQ(clip->tracks()[0].role, "depth");
    EXPECT_EQ(clip->tracks()[1].codec, "png");
    EXPECT_EQ(clip->tracks()[1].height, height);
    for (int round = 0; round < 2; ++round) {
        const auto frames = must(read_all(*clip));
        ASSERT_EQ(frames.size(), 5U);
        for (std::size_t n = 0; n < 5; ++n) {
            const RawFrame& frame = frames[n];
            PlaneView upper = pictures[n].view(), lower = upper;
            upper.height = lower.height = height;
            lower.data = upper.row(height);
            EXPECT_TRUE(same_plane(frame.colour, upper));
            EXPECT_TRUE(same_plane(frame.depth, lower));
            EXPECT_EQ(frame.time_ns, static_cast<std::int64_t>(n) * 1'001'000'000 / 30);
        }
        ASSERT_EQ(message(clip->rewind()), "");
    }
}

TEST_F(Depthkit, TellsOfGreyDepth) {
    const auto picture = [](int tint) {
        return made_image(width, 2 * height, 1, 3,
                          [=](int x, int y, int c) { return 90 + 9 * x + 7 * y + tint * c; });
    };
    const char* told = "depth is said to be hue, but frame 0 is grey in three channels";
    write_depthkit(folder, {picture(4)});
    EXPECT_TRUE(is_noted(*must(open_clip(folder / "Clip.mov")), told));
    write_depthkit(folder, {made_image(width, 2 * height, 1, 3, [](int, int, int) { return 0; })});
    EXPECT_FALSE(is_noted(*must(open_clip(folder / "Clip.mov")), told)) << "before the first person comes";
}

TEST_F(Depthkit, GivesWayToSceneFile) {
    write_depthkit(folder, noise(2));
    auto scene = (*open_clip(folder / "Clip.mov"))->scene();
    scene.rate = {12, 1};
    scene.filter = {};
    write_bytes(folder / "scene.json", scene_to_json(scene));
    auto clip = must(open_clip(folder / "Clip.mov", folder / "scene.json"));
    EXPECT_EQ(clip->scene().filter, FilterSettings{});
    ASSERT_FALSE(clip->notes().empty());
    EXPECT_EQ(clip->notes()[0], "played at 12/1 frames/s, as the scene file has it; recorded at 24/1");
    const auto frames = must(read_all(*clip));
    EXPECT_EQ(frames[1].time_ns, 83'333'333);

    scene.width = 9;
    write_bytes(folder / "scene.json", scene_to_json(scene));
    EXPECT_TRUE(
        is_refused(open_clip(folder / "Clip.mov", folder / "scene.json"), "is 8x6, but the scene is 9x6"));
    write_bytes(folder / "scene.json", scene_to_json(small_scene(width, height)));
    EXPECT_TRUE(is_refused(open_clip(folder / "Clip.mov", folder / "scene.json"), "8-bit RGB"));
}

/// The command that is proposed must do: a folder whose name has a dot ends in /.
TEST_F(Depthkit, ProposesFolderForConvert) {
    write_depthkit(folder, noise(1));
    const auto proposed = [&](const char* video) {
        const std::string refused = message(guess_clip(folder / video, {}));
        return refused.substr(std::min(refused.size(), refused.rfind(" ") + 1));
    };
    EXPECT_EQ(proposed("Clip.mov"), (folder / "Clip").string());
    for (const char* file : {"Clip.mov", "Clip.Metadata.asset"}) {
        const std::string name = file;
        std::filesystem::copy(folder / name, folder / ("My.1." + name));
    }
    EXPECT_EQ(proposed("My.1.Clip.mov"), (folder / "My.1.Clip").string() + "/");
    std::filesystem::create_directory(folder / "My.1.Clip");
    EXPECT_EQ(proposed("My.1.Clip.mov"), (folder / "My.1.Clip-2").string() + "/");
}

TEST_F(Depthkit, NamesInvalidMetadata) {
    const std::pair<std::string, std::vector<std::string>> cases[] = {
        {"", {"depthImageSize is missing"}},
        {with("nearClip: 0.5", "nearclip: 0.5"), {"nearClip is missing"}},
        {with("nearClip: 0.5", "nearClip: half"), {"nearClip is half", "a number"}},
        {with("nearClip: 0.5", "nearClip: 0.5 m"), {"nearClip is 0.5 m", "a number"}},
        {with("nearClip: 0.5", "nearClip: nan"), {"nearClip is nan"}},
        {with("nearClip: 0.5", "nearClip: 0"), {"depth.near is 0", "greater than 0"}},
        {with("nearClip: 0.5", "nearClip: 2"), {"depth.near is 2", "less than depth.far"}},
        {with("farClip: 1.5", "farClip: 1.5\n      farClip: 2"), {"farClip more than once"}},
        {with("{x: 7.5, y: 7.25}", "{x: 7.5}"), {"depthFocalLength is {x: 7.5}", "number y"}},
        {with("{x: 7.5, y: 7.25}", "{x: -7.5, y: 7}"), {"camera.fx is -7.5"}},
        {with("{x: 7.5, y: 7.25}", ""), {"depthFocalLength is ", "number x"}},
        {with("{x: 8, y: 6}", "{x: 8.5, y: 6}"), {"depthImageSize is 8.5", "whole number"}},
        {with("{x: 8, y: 6}", "{x: 8, y: -6}"), {"depthImageSize is -6"}},
        {with("textureHeight: 12", "textureHeight: 13"), {"textureHeight is 13", "must be 12"}},
        {with("perpixel", "mesh"), {"format is mesh", "perpixel"}},
        {with("{x: 0, y: 0, z: 1, w: 1}", "{x: 0.1, y: 0, z: 0.8, w: 1}"), {"crop is {x: 0.1"}},
        {std::string(2 << 20, 'x'), {"larger than 1 MiB"}},
        {std::string(1000, '\0'), {"depthImageSize is missing"}},
    };
    for (const auto& [text, words] : cases) {
        write_depthkit(folder, noise(1), text);
        const auto clip = open_clip(folder / "Clip.mov");
        ASSERT_FALSE(clip) << words.front();
        EXPECT_EQ(clip.error().kind, ErrorKind::input);
        EXPECT_TRUE(message(clip).starts_with((folder / "Clip.Metadata.asset").string() + ": "))
            << message(clip);
        for (const std::string& word : words)
            EXPECT_TRUE(is_refused(clip, word)) << word << " in: " << message(clip);
    }
}

TEST_F(Depthkit, NamesMissingMetadata) {
    write_quicktime(folder / "Clip.mov", noise(1), {24, 1});
    EXPECT_TRUE(
        is_refused(open_clip(folder / "Clip.mov"), "Depthkit video needs Clip.Metadata.asset beside it"));
    write_bytes(folder / "Other.mov", "no video at all");
    write_bytes(folder / "Other.Metadata.asset", metadata);
    EXPECT_TRUE(is_refused(open_clip(folder / "Other.mov"), "is truncated, or no QuickTime or MP4 file"));
}

TEST_F(Depthkit, RefusesSizeOtherThanMetadata) {
    for (const auto& [w, h, word] : {std::tuple{8, 10, "is 8x5, but the scene is 8x6"}, {8, 11, "8x11"}}) {
        write_depthkit(folder, noise(2, w, h));
        EXPECT_TRUE(is_refused(open_clip(folder / "Clip.mov"), word));
    }
}

TEST_F(Depthkit, RefusesUnevenFrames) {
    write_bytes(folder / "Clip.Metadata.asset", metadata);
    write_quicktime(folder / "Clip.mov", noise(6), {24000, 1000},
                    [](int number) { return number * 1000 + (number == 3 ? 400 : 0); });
    EXPECT_TRUE(is_refused(open_clip(folder / "Clip.mov"), "its frames are not evenly spaced"));
}

/// Its codec, its two halves, and a person who was cut out of the background: the head, blue in hue, half the
/// way to the far plane, above the hands, orange, a tenth of it.
TEST_F(Depthkit, ReadsPersonOfHap) {
    constexpr int wide = 64, high = 48;
    const auto is_head = [](int x, int y) { return x >= 24 && x < 40 && y >= 8 && y < 24; };
    const auto is_hands = [](int x, int y) { return x >= 12 && x < 52 && y >= 28 && y < 44; };
    const Image picture = made_image(wide, 2 * high, 1, 3, [&](int x, int row, int c) {
        const int y = row % high;
        if (!is_head(x, y) && !is_hands(x, y)) return 0;
        const Rgb depth = is_head(x, y) ? Rgb{0, 255, 255} : Rgb{255, 153, 0};
        return row < high ? 200 : depth[static_cast<std::size_t>(c)];
    });
    std::string text = with("textureWidth: 8", "textureWidth: 64");
    for (const auto& [from, to] : {std::pair{"textureHeight: 12", "textureHeight: 96"},
                                   {"{x: 8, y: 6}", "{x: 64, y: 48}"},
                                   {"{x: 3.75, y: 2.5}", "{x: 31.5, y: 23.5}"}})
        text.replace(text.find(from), std::string(from).size(), to);
    write_quicktime(folder / "Clip.mov", {picture, picture, picture}, {24, 1}, {}, QuicktimeCodec::hap);
    write_bytes(folder / "Clip.Metadata.asset", text);
    auto clip = must(open_clip(folder / "Clip.mov"));
    EXPECT_EQ(clip->tracks()[0].codec, "hap");
    const Scene& scene = clip->scene();
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 3U);
    for (const RawFrame& frame : frames)
        for (int y = 0; y < high; ++y)
            for (int x = 0; x < wide; ++x) {
                const std::uint16_t code = stored_code(frame.depth, scene.depth, x, y);
                const bool is_there = is_head(x, y) || is_hands(x, y);
                ASSERT_EQ(scene.depth.is_valid(code), is_there) << x << ", " << y;
                ASSERT_EQ(frame.colour.sample(x, y, 1) > 100, is_there) << x << ", " << y;
                if (!is_there) continue;
                // Colours of 5, 6 and 5 bits.
                ASSERT_NEAR(scene.depth.depth(code), is_head(x, y) ? 1.0 : 0.6, 0.015) << x << ", " << y;
            }
}

class RealDepthkit : public ::testing::Test {
protected:
    std::filesystem::path video = real_data("depthkit_typing/Test.mov");
    void SetUp() override { TOUCHABLE_NEEDS_DATA(video); }
};

TEST_F(RealDepthkit, AlignsColourAndDepth) {
    auto clip = must(open_clip(video));
    const Scene& scene = clip->scene();
    EXPECT_EQ(scene.width, 512);
    EXPECT_EQ(scene.height, 424);
    EXPECT_EQ(scene.rate.num, 24);
    EXPECT_EQ(scene.rate.den, 1);
    EXPECT_EQ(scene.camera.fx, 366.557);
    EXPECT_EQ(scene.camera.cy, 205.052);
    EXPECT_EQ(scene.depth.near, 0.5207);
    EXPECT_NEAR(scene.depth.depth(768), (0.5207 + 1.25961) / 2, 1e-12);
    EXPECT_EQ(clip->frame_count(), 48);
    EXPECT_EQ(clip->tracks()[0].codec, "hap");
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 48U);
    EXPECT_EQ(frames[47].time_ns, 47 * 1'000'000'000LL / 24);
    for (const RawFrame& frame : frames) {
        // The background was cut out of both halves; and of what is left the head is the top, the desk,
        // nearer than the head, the bottom.
        int together = 0, valid = 0;
        double upper = 0, lower = 0;
        int upper_count = 0, lower_count = 0;
        for (int y = 0; y < 424; ++y)
            for (int x = 0; x < 512; ++x) {
                const std::uint16_t code = stored_code(frame.depth, scene.depth, x, y);
                const bool is_valid = scene.depth.is_valid(code);
                const bool coloured = frame.colour.sample(x, y, 0) + frame.colour.sample(x, y, 1) +
                                          frame.colour.sample(x, y, 2) >
                                      0;
                together += is_valid == coloured;
                valid += is_valid;
                if (is_valid && y < 150) upper += scene.depth.depth(code), ++upper_count;
                if (is_valid && y > 280) lower += scene.depth.depth(code), ++lower_count;
            }
        EXPECT_GT(together, 0.93 * 512 * 424);
        EXPECT_GT(valid, 0.25 * 512 * 424);
        ASSERT_GT(upper_count, 1000);
        ASSERT_GT(lower_count, 1000);
        EXPECT_GT(upper / upper_count, 0.8);
        EXPECT_LT(lower / lower_count, 0.75);
    }
}

}  // namespace
}  // namespace touchable::test
