#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/real_data.hpp"
#include "tests/video/quicktime.hpp"

namespace touchable::test {
namespace {

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
    Numbers numbers(5);
    std::vector<Image> pictures;
    for (int n = 0; n < frames; ++n) {
        Image image{image_width, image_height, 1, 3, {}};
        for (int k = 0; k < 3 * image_width * image_height; ++k)
            image.samples.push_back(static_cast<std::uint8_t>(numbers.below(256)));
        pictures.push_back(std::move(image));
    }
    return pictures;
}

void write_depthkit(const TemporaryFolder& folder, const std::vector<Image>& pictures,
                    const std::string& text = metadata, const FrameRate& rate = {24, 1}) {
    write_quicktime(folder / "Clip.mov", pictures, rate);
    write_bytes(folder / "Clip.Metadata.asset", text);
}

TEST(Depthkit, UpperHalfIsColourAndLowerHalfIsDepth) {
    const TemporaryFolder folder;
    const auto pictures = noise(5);
    write_depthkit(folder, pictures, metadata, {30000, 1001});
    auto clip = open_clip(folder / "Clip.mov");
    ASSERT_EQ(message(clip), "");
    const Scene& scene = (*clip)->scene();
    EXPECT_EQ(scene.name, "Clip");
    EXPECT_EQ(scene.width, width);
    EXPECT_EQ(scene.height, height);
    EXPECT_EQ(scene.rate.num, 30000);
    EXPECT_EQ(scene.rate.den, 1001);
    EXPECT_EQ(scene.metres_per_unit, 1.0);
    EXPECT_EQ(scene.camera.fx, 7.5);
    EXPECT_EQ(scene.camera.fy, 7.25);
    EXPECT_EQ(scene.camera.cx, 3.75);
    EXPECT_EQ(scene.camera.cy, 2.5);
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
    EXPECT_EQ((*clip)->frame_count(), 5);
    ASSERT_EQ((*clip)->tracks().size(), 2U);
    EXPECT_EQ((*clip)->tracks()[0].role, "depth");
    EXPECT_EQ((*clip)->tracks()[1].codec, "png");
    EXPECT_EQ((*clip)->tracks()[1].height, height);
    for (int round = 0; round < 2; ++round) {
        const auto frames = read_all(**clip);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 5U);
        for (std::size_t n = 0; n < 5; ++n) {
            const RawFrame& frame = (*frames)[n];
            PlaneView upper = pictures[n].view(), lower = upper;
            upper.height = lower.height = height;
            lower.data = upper.row(height);
            EXPECT_TRUE(same_plane(frame.colour, upper));
            EXPECT_TRUE(same_plane(frame.depth, lower));
            EXPECT_EQ(frame.time_ns, static_cast<std::int64_t>(n) * 1'001'000'000 / 30);
        }
        ASSERT_EQ(message((*clip)->rewind()), "");
    }
}

TEST(Depthkit, IsSoughtByItsIndexWhereEveryFrameIsAKey) {
    for (const FrameRate& rate : {FrameRate{24, 1}, FrameRate{30000, 1001}}) {
        const TemporaryFolder folder;
        const auto pictures = noise(7);
        write_depthkit(folder, pictures, metadata, rate);
        auto clip = open_clip(folder / "Clip.mov");
        ASSERT_EQ(message(clip), "");
        for (const std::int64_t frame : {5, 2, 2, 6, 0, 3}) {
            EXPECT_EQ((*clip)->access_point(frame), frame);
            ASSERT_EQ(message((*clip)->seek(frame)), "");
            for (std::int64_t n = frame; n < 7; ++n) {
                const auto read = (*clip)->next();
                ASSERT_EQ(message(read), "");
                ASSERT_TRUE(*read);
                EXPECT_EQ((*read)->number, n);
                PlaneView upper = pictures[static_cast<std::size_t>(n)].view();
                upper.height = height;
                EXPECT_TRUE(same_plane((*read)->colour, upper)) << n;
                if (frame == 2) break;  // and on from there
            }
        }
        ASSERT_EQ(message((*clip)->seek(7)), "");
        const auto end = (*clip)->next();
        ASSERT_EQ(message(end), "");
        EXPECT_FALSE(*end);
        EXPECT_NE(message((*clip)->seek(8)), "");
        EXPECT_NE(message((*clip)->seek(-1)), "");
    }
}

TEST(Depthkit, ASceneFileReplacesTheDescription) {
    const TemporaryFolder folder;
    write_depthkit(folder, noise(2));
    auto scene = (*open_clip(folder / "Clip.mov"))->scene();
    scene.rate = {12, 1};
    scene.filter = {};
    write_bytes(folder / "scene.json", scene_to_json(scene));
    auto clip = open_clip(folder / "Clip.mov", folder / "scene.json");
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->scene().filter, FilterSettings{});
    ASSERT_FALSE((*clip)->notes().empty());
    EXPECT_EQ((*clip)->notes()[0], "played at 12/1 frames/s, as the scene file has it; recorded at 24/1");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    EXPECT_EQ((*frames)[1].time_ns, 83'333'333);

    scene.width = 9;
    write_bytes(folder / "scene.json", scene_to_json(scene));
    EXPECT_TRUE(
        is_refused(open_clip(folder / "Clip.mov", folder / "scene.json"), "is 8x6, but the scene is 9x6"));
    write_bytes(folder / "scene.json", scene_to_json(small_scene(width, height)));
    EXPECT_TRUE(is_refused(open_clip(folder / "Clip.mov", folder / "scene.json"), "8-bit RGB"));
}

/// The command that is proposed must do: a folder whose name has a dot ends in /.
TEST(Depthkit, AFolderIsProposedForItsPicturesAsConvertTakesIt) {
    const TemporaryFolder folder;
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

TEST(Depthkit, MetadataThatDoNotFitAreRefusedByName) {
    const TemporaryFolder folder;
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
            EXPECT_NE(message(clip).find(word), std::string::npos) << word << " in: " << message(clip);
    }
}

TEST(Depthkit, AVideoWithoutMetadataIsRefusedSayingWhatIsMissing) {
    const TemporaryFolder folder;
    write_quicktime(folder / "Clip.mov", noise(1), {24, 1});
    EXPECT_TRUE(
        is_refused(open_clip(folder / "Clip.mov"), "Depthkit video needs Clip.Metadata.asset beside it"));
    write_bytes(folder / "Other.mov", "no video at all");
    write_bytes(folder / "Other.Metadata.asset", metadata);
    EXPECT_TRUE(is_refused(open_clip(folder / "Other.mov"), "is truncated, or no QuickTime or MP4 file"));
}

TEST(Depthkit, AVideoThatIsNotAsTheMetadataSayIsRefused) {
    const TemporaryFolder folder;
    for (const auto& [w, h, word] : {std::tuple{8, 10, "is 8x5, but the scene is 8x6"}, {8, 11, "8x11"}}) {
        write_depthkit(folder, noise(2, w, h));
        EXPECT_TRUE(is_refused(open_clip(folder / "Clip.mov"), word));
    }
}

TEST(Depthkit, FramesThatAreNotEvenlySpacedAreRefused) {
    const TemporaryFolder folder;
    write_bytes(folder / "Clip.Metadata.asset", metadata);
    write_quicktime(folder / "Clip.mov", noise(6), {24000, 1000},
                    [](int number) { return number * 1000 + (number == 3 ? 400 : 0); });
    auto clip = open_clip(folder / "Clip.mov");
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_refused(read_all(**clip), "frame 3: is not at its time"));
}

/// Its codec, its two halves, and a person who was cut out of the background: the head, blue in hue, half the
/// way to the far plane, above the hands, orange, a tenth of it.
TEST(Depthkit, OfHapIsWhatWasCutOutOfBothHalves) {
    constexpr int wide = 64, high = 48;
    const TemporaryFolder folder;
    Image picture{wide, 2 * high, 1, 3, std::vector<std::uint8_t>(3 * wide * 2 * high, 0)};
    const auto is_head = [](int x, int y) { return x >= 24 && x < 40 && y >= 8 && y < 24; };
    const auto is_hands = [](int x, int y) { return x >= 12 && x < 52 && y >= 28 && y < 44; };
    for (int y = 0; y < high; ++y)
        for (int x = 0; x < wide; ++x) {
            if (!is_head(x, y) && !is_hands(x, y)) continue;
            const std::array<std::uint8_t, 3> depth = is_head(x, y)
                                                          ? std::array<std::uint8_t, 3>{0, 255, 255}
                                                          : std::array<std::uint8_t, 3>{255, 153, 0};
            for (std::size_t c = 0; c < 3; ++c) {
                picture.samples[static_cast<std::size_t>(3 * (wide * y + x)) + c] = 200;
                picture.samples[static_cast<std::size_t>(3 * (wide * (high + y) + x)) + c] = depth[c];
            }
        }
    std::string text = with("textureWidth: 8", "textureWidth: 64");
    for (const auto& [from, to] : {std::pair{"textureHeight: 12", "textureHeight: 96"},
                                   {"{x: 8, y: 6}", "{x: 64, y: 48}"},
                                   {"{x: 3.75, y: 2.5}", "{x: 31.5, y: 23.5}"}})
        text.replace(text.find(from), std::string(from).size(), to);
    write_quicktime(folder / "Clip.mov", {picture, picture, picture}, {24, 1}, {}, QuicktimeCodec::hap);
    write_bytes(folder / "Clip.Metadata.asset", text);
    auto clip = open_clip(folder / "Clip.mov");
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->tracks()[0].codec, "hap");
    const Scene& scene = (*clip)->scene();
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    for (const RawFrame& frame : *frames)
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

TEST_F(RealDepthkit, IsAPersonAtADeskWhoseColourAndDepthLieOverEachOther) {
    auto clip = open_clip(video);
    ASSERT_EQ(message(clip), "");
    const Scene& scene = (*clip)->scene();
    EXPECT_EQ(scene.width, 512);
    EXPECT_EQ(scene.height, 424);
    EXPECT_EQ(scene.rate.num, 24);
    EXPECT_EQ(scene.rate.den, 1);
    EXPECT_EQ(scene.camera.fx, 366.557);
    EXPECT_EQ(scene.camera.cy, 205.052);
    EXPECT_EQ(scene.depth.near, 0.5207);
    EXPECT_NEAR(scene.depth.depth(768), (0.5207 + 1.25961) / 2, 1e-12);
    EXPECT_EQ((*clip)->frame_count(), 48);
    EXPECT_EQ((*clip)->tracks()[0].codec, "hap");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 48U);
    EXPECT_EQ((*frames)[47].time_ns, 47 * 1'000'000'000LL / 24);
    for (const RawFrame& frame : *frames) {
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
