// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/clip/tracks.hpp"
#include "engine/scene/scene.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/picture/results.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

/// The code of depth at a pixel; no two frames or rows alike.
int code_at(int x, int y, int frame, int most) {
    return (x * 37 + y * 101 + frame * 59 + x * y * 3) % (most + 1);
}

/// A scene file of a video; members in `depth` and `video` as text.
void write_scene(const std::filesystem::path& file, int width, int height, const std::string& depth,
                 const std::string& video, const std::string& more = "") {
    write_bytes(file, R"({"touchable_scene": 1, "width": )" + std::to_string(width) + R"(, "height": )" +
                          std::to_string(height) +
                          R"(, "camera": {"fx": 30, "fy": 30, "cx": 15.5, "cy": 7.5}, "depth": {)" + depth +
                          R"(}, "video": {)" + video + "}" + more + "}");
}
const std::string linear8 = R"("coding": "linear", "near": 100, "far": 200, "bits": 8)";

std::string linear(int bits) {
    return R"("coding": "linear", "near": 100, "far": 200, "bits": )" + std::to_string(bits);
}

/// Every code of a clip's depth; `expected(x, y, frame)`.
template <class Expected>
void expect_depth(ClipReader& reader, int frames, Expected&& expected) {
    const auto read = must(read_all(reader));
    ASSERT_EQ(read.size(), static_cast<std::size_t>(frames));
    for (int n = 0; n < frames; ++n) {
        const PlaneView& depth = read[static_cast<std::size_t>(n)].depth;
        for (int y = 0; y < depth.height; ++y)
            for (int x = 0; x < depth.width; ++x)
                ASSERT_EQ(depth.sample(x, y), expected(x, y, n)) << x << "," << y << " of frame " << n;
    }
}

using VideoClip = FolderTest;

TEST_F(VideoClip, ReadsGreyOfAllBits) {
    for (const auto& [format, bits, codec, name] : {std::tuple{AV_PIX_FMT_GRAY8, 8, "ffv1", "d.mkv"},
                                                    {AV_PIX_FMT_GRAY10LE, 10, "ffv1", "d.mkv"},
                                                    {AV_PIX_FMT_GRAY12LE, 12, "ffv1", "d.mkv"},
                                                    {AV_PIX_FMT_GRAY16LE, 16, "ffv1", "d.mov"},
                                                    {AV_PIX_FMT_GRAY8, 8, "ffv1", "d.avi"},
                                                    {AV_PIX_FMT_YUV420P10LE, 10, "ffv1", "d.mkv"},
                                                    {AV_PIX_FMT_GRAY16BE, 16, "png", "d.mp4"}}) {
        const int most = (1 << bits) - 1;
        const bool is_big_endian = format == AV_PIX_FMT_GRAY16BE;
        ForeignVideo video{codec, format};
        write_video(folder / name, video, [&](AVFrame& frame, int n) {
            fill_plane(frame, 0, [&](int x, int y) {
                const int code = code_at(x, y, n, most);
                return is_big_endian ? (code & 255) << 8 | code >> 8 : code;
            });
            for (int plane = 1; plane < 3 && frame.data[plane]; ++plane)
                fill_plane(frame, plane, [&](int, int) { return 512; });
        });
        write_scene(folder / "scene.json", 32, 16, linear(bits), R"("depth": ")" + std::string(name) + "\"");
        auto clip = open_clip(folder / "scene.json");
        ASSERT_EQ(message(clip), "") << name << ", " << bits << " bits";
        EXPECT_EQ((*clip)->frame_count(), 3);
        EXPECT_EQ((*clip)->scene().rate.num, 30 * (*clip)->scene().rate.den);
        EXPECT_EQ((*clip)->tracks().size(), 1U);
        EXPECT_EQ((*clip)->inputs().size(), 2U);
        expect_depth(**clip, 3, [&](int x, int y, int n) { return code_at(x, y, n, most); });
    }
}

TEST_F(VideoClip, KeepsLumaOfAnyRange) {
    for (const AVColorRange range : {AVCOL_RANGE_UNSPECIFIED, AVCOL_RANGE_MPEG, AVCOL_RANGE_JPEG}) {
        ForeignVideo video{"ffv1", AV_PIX_FMT_YUV420P};
        video.range = range;
        write_video(folder / "d.mkv", video, [](AVFrame& frame, int n) {
            fill_plane(frame, 0, [&](int x, int y) { return code_at(x, y, n, 255); });
            for (int plane = 1; plane < 3; ++plane) fill_plane(frame, plane, [&](int, int) { return 128; });
        });
        write_scene(folder / "scene.json", 32, 16, linear8, R"("depth": "d.mkv")");
        auto clip = must(open_clip(folder / "scene.json"));
        expect_depth(*clip, 3, [](int x, int y, int n) { return code_at(x, y, n, 255); });
    }
}

/// Grey of 8 bits.
void write_codes(const std::filesystem::path& file, const ForeignVideo& video = {}) {
    write_video(file, video, [](AVFrame& frame, int n) {
        fill_plane(frame, 0, [&](int x, int y) { return code_at(x, y, n, 255); });
    });
}

ForeignVideo rgb_video(int width, int height, int frames = 2) {
    ForeignVideo video{"png", AV_PIX_FMT_RGB24, width, height};
    video.frames = frames;
    return video;
}

TEST_F(VideoClip, AveragesRgb) {
    write_video(folder / "d.mov", rgb_video(32, 16), [](AVFrame& frame, int n) {
        fill_rgb(frame, [&](int x, int y) {
            return std::array{code_at(x, y, n, 255), code_at(y, x, n, 255), code_at(x, n, y, 255)};
        });
    });
    write_scene(folder / "scene.json", 32, 16, linear8, R"("depth": "d.mov", "values": "mean")");
    auto clip = must(open_clip(folder / "scene.json"));
    expect_depth(*clip, 2, [](int x, int y, int n) {
        const int sum = code_at(x, y, n, 255) + code_at(y, x, n, 255) + code_at(x, n, y, 255);
        return static_cast<int>(std::lround(sum / 3.0));
    });
    write_scene(folder / "scene.json", 32, 16, linear8, R"("depth": "d.mov", "values": "grey")");
    EXPECT_TRUE(is_refused(open_clip(folder / "scene.json"), "track depth, frame 0: is in colour"));
}

TEST_F(VideoClip, StretchesMeanOfLimitedLuma) {
    for (const bool is_full : {false, true}) {
        ForeignVideo video{"ffv1", AV_PIX_FMT_YUV444P, 32, 16, 1};
        video.range = is_full ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
        const auto luma = [](int x, int y) { return 16 + (x + 32 * y) % 220; };
        write_video(folder / "d.mkv", video, [&](AVFrame& frame, int) {
            for (int plane = 0; plane < 3; ++plane)
                fill_plane(frame, plane, [&](int x, int y) { return plane ? 128 : luma(x, y); });
        });
        write_scene(folder / "scene.json", 32, 16, linear8, R"("depth": "d.mkv", "values": "mean")");
        auto clip = must(open_clip(folder / "scene.json"));
        expect_depth(*clip, 1, [&](int x, int y, int) {
            return is_full ? luma(x, y) : static_cast<int>(std::lround((luma(x, y) - 16) * 255 / 219.0));
        });
    }
}

/// Colour and depth in one picture.
struct Half {
    const char* layout;
    int depth_x, depth_y, width, height;
};

TEST_F(VideoClip, SplitsHalves) {
    for (const Half& half : {Half{"left", 0, 0, 40, 10}, Half{"right", 20, 0, 40, 10},
                             Half{"top", 0, 0, 20, 20}, Half{"bottom", 0, 10, 20, 20}}) {
        const auto red = [](int x, int y) { return 255 - 5 * x - y; };
        write_video(folder / "d.mov", rgb_video(half.width, half.height), [&](AVFrame& frame, int n) {
            fill_rgb(frame, [&](int x, int y) {
                const bool is_depth =
                    x >= half.depth_x && x < half.depth_x + 20 && y >= half.depth_y && y < half.depth_y + 10;
                const int code = code_at(x % 20, y % 10, n, 255);
                return is_depth ? std::array{code, code, code} : std::array{red(x % 20, y % 10), 7, n};
            });
        });
        const auto expect_it = [&](ClipReader& clip) {
            const auto frames = read_all(clip);
            ASSERT_EQ(message(frames), "");
            ASSERT_EQ(frames->size(), 2U);
            for (int n = 0; n < 2; ++n) {
                const RawFrame& frame = (*frames)[static_cast<std::size_t>(n)];
                ASSERT_EQ(frame.depth.width, 20);
                ASSERT_EQ(frame.colour.height, 10);
                for (int y = 0; y < 10; ++y)
                    for (int x = 0; x < 20; ++x) {
                        ASSERT_EQ(frame.depth.sample(x, y), code_at(x, y, n, 255)) << half.layout;
                        ASSERT_EQ(frame.colour.sample(x, y, 0), red(x, y)) << half.layout;
                        ASSERT_EQ(frame.colour.sample(x, y, 2), n) << half.layout;
                    }
            }
        };
        write_scene(folder / "scene.json", 20, 10, linear8,
                    R"("depth": "d.mov", "layout": ")" + std::string(half.layout) + "\"");
        auto clip = open_clip(folder / "scene.json");
        ASSERT_EQ(message(clip), "");
        expect_it(**clip);
        clip = open_clip(folder / "d.mov");  // is guessed alike
        ASSERT_EQ(message(clip), "") << half.layout;
        expect_it(**clip);
        EXPECT_TRUE(is_noted(**clip, "half, which is grey"));
    }
}

TEST_F(VideoClip, PairsColourFileByTime) {
    write_codes(folder / "d.mkv", {.frames = 6});
    for (const int slower : {1, 2}) {
        ForeignVideo colour = rgb_video(16, 8, 6 / slower);
        colour.rate = {30 / slower, 1};
        write_video(folder / "c.mov", colour, [](AVFrame& frame, int n) {
            fill_rgb(frame, [&](int, int) { return std::array{n, 10, 200}; });
        });
        write_scene(folder / "scene.json", 32, 16, linear8, R"("depth": "d.mkv", "colour": "c.mov")");
        auto clip = must(open_clip(folder / "scene.json"));
        EXPECT_TRUE(is_noted(*clip, "resampled to the nearest pixel of depth's 32x16"));
        EXPECT_EQ(is_noted(*clip, "nearest in time"), slower == 2);
        const auto frames = must(read_all(*clip));
        ASSERT_EQ(frames.size(), 6U);
        for (int n = 0; n < 6; ++n)  // between two of colour, the earlier
            EXPECT_EQ(frames[static_cast<std::size_t>(n)].colour.sample(3, 3, 0), n / slower);
        clip->leave_out_colour();
        ASSERT_EQ(message(clip->rewind()), "");
        EXPECT_TRUE((*read_all(*clip))[2].colour.empty());
    }
}

TEST_F(VideoClip, SeeksSameFrames) {
    for (const char* name : {"d.mp4", "d.avi", "d.mkv"}) {
        ForeignVideo video{"mpeg4", AV_PIX_FMT_YUV420P, 32, 16, 12};
        video.interval = 5;
        write_video(folder / name, video, [](AVFrame& frame, int n) {
            for (int plane = 0; plane < 3; ++plane)
                fill_plane(frame, plane, [&](int x, int) { return plane ? 128 : 20 + 15 * n + x; });
        });
        auto clip = open_clip(folder / name);
        ASSERT_EQ(message(clip), "") << name;
        EXPECT_TRUE(is_noted(**clip, "depth is stored as mpeg4, which changes values"));
        EXPECT_EQ((*clip)->access_point(9), 5);
        const auto all = must(read_all(**clip));
        ASSERT_EQ(all.size(), 12U);
        for (const int n : {7, 11, 2, 5, 0, 10, 4}) {
            ASSERT_EQ(message((*clip)->seek(n)), "");
            const auto frame = (*clip)->next();
            ASSERT_EQ(message(frame), "");
            EXPECT_TRUE(same_frame(**frame, all[static_cast<std::size_t>(n)])) << name << ", frame " << n;
        }
        ASSERT_EQ(message((*clip)->seek(12)), "");
        EXPECT_FALSE(*(*clip)->next());
        EXPECT_EQ((*clip)->seek(13).error().kind, ErrorKind::usage);
    }
}

TEST_F(VideoClip, TakesRateOfContainer) {
    for (const char* name : {"d.mkv", "d.mov"}) {
        ForeignVideo video{.frames = 40, .rate = {30000, 1001}};
        write_codes(folder / name, video);
        auto clip = must(open_clip(folder / name));
        EXPECT_EQ(clip->scene().rate.num, 30000);
        EXPECT_EQ(clip->scene().rate.den, 1001);
        EXPECT_FALSE(is_noted(*clip, "evenly"));
        write_scene(folder / "scene.json", 32, 16, linear8, R"("depth": ")" + std::string(name) + "\"",
                    R"(, "rate": [15, 1])");
        clip = must(open_clip(folder / "scene.json"));
        EXPECT_EQ(clip->scene().rate.num, 15);
        EXPECT_TRUE(is_noted(*clip, "recorded at 30000/1001"));
    }
    ForeignVideo uneven{.frames = 5, .rate = {100, 1}};
    uneven.time_of = [](int n) { return n * n; };  // 0, 1, 4, 9, 16 hundredths
    write_codes(folder / "d.mkv", uneven);
    auto clip = must(open_clip(folder / "d.mkv"));
    EXPECT_EQ(clip->scene().rate.per_second(), 25);
    EXPECT_FALSE(is_noted(*clip, "played at"));
    const auto frames = read_all(*clip);
    for (int n = 0; n < 5; ++n)
        EXPECT_EQ(frames->at(static_cast<std::size_t>(n)).time_ns, n * n * std::int64_t{10'000'000}) << n;
}

TEST_F(VideoClip, IgnoresRateBeyondScene) {
    constexpr int most = std::numeric_limits<int>::max();
    const auto measured = VideoFile::measured_rate({0, 1, 2}, {1, most}, {{most, 1}});
    EXPECT_LE(measured.rate.num, 1'000'000'000);
    EXPECT_FALSE(measured.is_kept);
}

TEST_F(VideoClip, ScalesRelativeDepthByBits) {
    for (const bool is_limited : {false, true}) {
        ForeignVideo video{"ffv1", is_limited ? AV_PIX_FMT_YUV444P : AV_PIX_FMT_GRAY8};
        if (is_limited) video.range = AVCOL_RANGE_MPEG;
        write_video(folder / "d.mkv", video, [](AVFrame& frame, int) {
            for (int plane = 0; plane < 3 && frame.data[plane]; ++plane)
                fill_plane(frame, plane, [&](int x, int y) { return plane ? 128 : 30 + 2 * x + y; });
        });
        for (const char* coding : {"relative", "relative-inverse"}) {
            write_scene(folder / "scene.json", 32, 16,
                        R"("coding": ")" + std::string(coding) + R"(", "near": 0.5, "far": 1.5, "bits": 8)",
                        R"("depth": "d.mkv")");
            auto clip = must(open_clip(folder / "scene.json"));
            const DepthCoding& depth = clip->scene().depth;
            EXPECT_TRUE(clip->scene().stored.is_plain());
            EXPECT_NEAR(depth.depth(is_limited ? 16 : 0), 1.5, 1e-12);
            EXPECT_NEAR(depth.depth(is_limited ? 235 : 255), 0.5, 1e-12);
            const double share = is_limited ? 100.0 / 219 : 116.0 / 255;
            const bool is_inverse = std::string(coding) != "relative";
            EXPECT_NEAR(depth.depth(116), is_inverse ? 1 / (1 / 1.5 + (2 - 1 / 1.5) * share) : 1.5 - share,
                        1e-12);
            expect_depth(*clip, 3, [](int x, int y, int) { return 30 + 2 * x + y; });
        }
    }
}

TEST_F(VideoClip, FindsMissingFarPlane) {
    write_video(folder / "d.mkv", {"ffv1", AV_PIX_FMT_GRAY16LE}, [](AVFrame& frame, int n) {
        fill_plane(frame, 0, [&](int x, int) { return 500 + x + 100 * n; });
    });
    write_scene(folder / "scene.json", 32, 16, R"("coding": "metric", "scale": 1, "invalid": [0])",
                R"("depth": "d.mkv")");
    auto clip = must(open_clip(folder / "scene.json"));
    EXPECT_NEAR(clip->scene().depth.far, 1.05 * 731, 1);
    expect_depth(*clip, 3, [](int x, int, int n) { return 500 + x + 100 * n; });
}

TEST_F(VideoClip, NamesMisfitInOneLine) {
    write_codes(folder / "d.mkv", {"ffv1", AV_PIX_FMT_GRAY8, 33, 17});
    const std::string named = R"("depth": "d.mkv")";
    const std::tuple<std::string, std::string, std::string> cases[] = {
        {linear8, named + R"(, "layout": "left")", "frame 0: is 33x17: does not divide into two halves"},
        {linear8, named + R"(, "layout": "top")", "frame 0: is 33x17: does not divide into two halves"},
        {linear8, named, "frame 0: is 33x17, but the scene is 16x17"},
        {linear(16), named, "is 8-bit grey, but the scene's depth.bits, 16"},
        {linear8, named + R"(, "layout": "middle")", "video.layout is"},
        {linear8, named + R"(, "layout": "left", "colour": "c.mov")", "video.colour is \"c.mov\""},
        {linear8, named + R"(, "values": "hue")", "video.values: must be grey or mean"},
        {linear8, R"("depth": "none.mkv")", "none.mkv: is no file: must be a video"},
        {linear8, named + R"(, "colour": "none.mov")", "none.mov: is no file: must be a video"},
        {linear8, R"("depth": "scene.json")", "scene.json: is truncated, or no QuickTime"},
        {R"("coding": "disparity", "baseline": 0.1)", named, "must be linear, inverse, metric"},
    };
    for (const auto& [depth, video, words] : cases) {
        write_scene(folder / "scene.json", 16, 17, depth, video);
        const std::string said = message(open_clip(folder / "scene.json"));
        EXPECT_TRUE(has_words(said, words));
        EXPECT_EQ(said.find('\n'), std::string::npos);
    }
}

// Reading a damaged frame again gives the damage again, not the frame behind it.
TEST_F(VideoClip, KeepsPlacesBehindDamage) {
    write_codes(folder / "d.mkv", {.codec = "png", .frames = 8});
    const std::string whole = read_bytes(folder / "d.mkv");
    int damaged = 0;
    for (std::size_t at = whole.size() / 4; at < whole.size(); at += 1 + whole.size() / 60) {
        std::string bytes = whole;
        for (std::size_t k = at; k < std::min(at + 8, bytes.size()); ++k)
            bytes[k] = static_cast<char>(~bytes[k]);
        write_bytes(folder / "d.mkv", bytes);
        auto clip = open_clip(folder / "d.mkv");
        if (!clip) continue;
        std::int64_t number = 0;
        auto frame = (*clip)->next();
        for (; frame && *frame; frame = (*clip)->next()) ++number;
        if (frame) continue;
        ++damaged;
        for (int again = 0; again < 2; ++again) {
            if (!(*clip)->seek(number)) continue;
            EXPECT_FALSE((*clip)->next()) << "frame " << number << ", damaged at " << at;
        }
    }
    EXPECT_GT(damaged, 3);
}

TEST_F(VideoClip, RefusesTruncatedFile) {
    for (const char* name : {"d.mkv", "d.mov", "d.avi"}) {
        write_codes(folder / name);
        const std::string whole = read_bytes(folder / name);
        ASSERT_EQ(message(read_clip(folder / name)), "") << name;
        for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 25) {
            write_bytes(folder / name, whole.substr(0, length));
            ASSERT_FALSE(read_clip(folder / name)) << name << ": " << length << " of " << whole.size();
        }
    }
}

// iPhone's Cinematic videos.

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
            fill_plane(frame, plane, [&](int x, int) { return plane ? 90 + x : 60 + x + n; });
    });
    ForeignVideo depth{"libx265", AV_PIX_FMT_YUV420P, disparity_width, disparity_height, 4};
    depth.range = AVCOL_RANGE_JPEG;
    write_video(folder / "d.mov", depth, [](AVFrame& frame, int n) {
        for (int plane = 0; plane < 3; ++plane)
            fill_plane(frame, plane, [&](int x, int y) { return plane ? 128 : disparity_at(x, y, n); });
    });
    join_cinematic(folder / "c.mov", folder / "d.mov", file);
}

TEST(Cinematic, RefusesCutFiles) {
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
