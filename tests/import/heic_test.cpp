#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine/formats/depth_photo.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/exif_bytes.hpp"
#include "tests/import/heic_file.hpp"

namespace touchable::test {
namespace {

constexpr int heic_wide = 96, heic_high = 64, deep_wide = 72, deep_high = 48;
constexpr double unsaid = std::numeric_limits<double>::quiet_NaN();

int deep_at(int x, int y) {
    return 3 * x + y / 4;
}

/// Bright in its upper left quarter.
Image heic_colour() {
    Image image{heic_wide, heic_high, 1, 3, {}};
    for (int y = 0; y < heic_high; ++y)
        for (int x = 0; x < heic_wide; ++x)
            image.samples.insert(image.samples.end(), 3, x < heic_wide / 2 && y < heic_high / 2 ? 220 : 40);
    return image;
}
Image heic_depth(int bits = 8) {
    Image image{deep_wide, deep_high, bits > 8 ? 2 : 1, 1, {}};
    for (int y = 0; y < deep_high; ++y)
        for (int x = 0; x < deep_wide; ++x) {
            const int code = deep_at(x, y) * (bits > 8 ? 4 : 1);
            image.samples.push_back(static_cast<std::uint8_t>(code & 255));
            if (bits > 8) image.samples.push_back(static_cast<std::uint8_t>(code >> 8));
        }
    return image;
}
HeicFile heic_portrait() {
    HeicFile file;
    file.colour = heic_colour();
    file.depth = heic_depth();
    return file;
}

std::string apple_xmp(const std::string& type, const std::string& least, const std::string& most,
                      const std::string& more = "") {
    return "<x:xmpmeta><rdf:RDF><rdf:Description><apdi:AuxiliaryImageType>" + type +
           "</apdi:AuxiliaryImageType><apdi:FloatMinValue>" + least +
           "</apdi:FloatMinValue><apdi:FloatMaxValue>" + most + "</apdi:FloatMaxValue>" + more +
           "</rdf:Description></rdf:RDF></x:xmpmeta>";
}

class Heic : public ::testing::Test {
protected:
    Result<std::unique_ptr<ClipReader>> open(const std::string& bytes, std::optional<double> fov = {}) {
        std::filesystem::remove(folder / "photo.heic");  // what is written over is waited for
        write_bytes(folder / "photo.heic", bytes);
        SourceDescription known;
        known.fov = fov;
        return open_clip(folder / "photo.heic", std::nullopt, fov ? std::optional(known) : std::nullopt);
    }
    static RawFrame frame_of(const Result<std::unique_ptr<ClipReader>>& clip) {
        EXPECT_EQ(message(clip), "");
        if (!clip) return {};
        auto frames = read_all(**clip);
        EXPECT_EQ(message(frames), "");
        return frames->front();
    }
    TemporaryFolder folder;
};

TEST_F(Heic, DepthIsBetweenTheCodecsPlanes) {
    HeicFile file = heic_portrait();
    file.depth_sei = depth_info_sei({0, 0.5, 4, unsaid, unsaid});
    auto clip = open(file.bytes());
    const RawFrame frame = frame_of(clip);
    const Scene& scene = (*clip)->scene();
    ASSERT_EQ(scene.width, deep_wide);
    ASSERT_EQ(scene.height, deep_high);
    for (int y = 0; y < deep_high; ++y)
        for (int x = 0; x < deep_wide; ++x) ASSERT_EQ(frame.depth.sample(x, y), deep_at(x, y));
    for (int v = 0; v < 256; ++v)  // inverse Z evenly, the largest value near
        EXPECT_NEAR(scene.depth.depth(static_cast<std::uint16_t>(v)), 1 / (0.25 + v / 255.0 * (2 - 0.25)),
                    1e-6);
    EXPECT_EQ(frame.colour.width, deep_wide);
    EXPECT_GT(frame.colour.sample(1, 1, 0), 200);
    EXPECT_LT(frame.colour.sample(deep_wide - 1, 1, 0), 60);
    EXPECT_TRUE(is_noted(**clip, "guessed: lengths are metres"));
    EXPECT_TRUE(is_noted(**clip, "guessed: the camera sees 60 degrees"));
    EXPECT_TRUE(is_noted(**clip, "colour is 96x64: resampled"));
    file.depth_sei = depth_info_sei({2, 0.5, 4, unsaid, unsaid});
    clip = open(file.bytes());
    ASSERT_EQ(message(clip), "");
    for (int v = 0; v < 256; ++v)
        EXPECT_NEAR((*clip)->scene().depth.depth(static_cast<std::uint16_t>(v)), 0.5 + v / 255.0 * 3.5, 1e-6);
}

TEST_F(Heic, DepthMayBeOfTenBits) {
    HeicFile file = heic_portrait();
    file.depth = heic_depth(10);
    file.depth_bits = 10;
    file.depth_sei = depth_info_sei({0, 0.5, 4, unsaid, unsaid});
    const auto clip = open(file.bytes());
    const RawFrame frame = frame_of(clip);
    EXPECT_EQ((*clip)->scene().depth.code_max, 1023);
    for (int x = 0; x < deep_wide; ++x) ASSERT_EQ(frame.depth.sample(x, 7), 4 * deep_at(x, 7));
}

TEST_F(Heic, DepthMayBeStoredAsColourThatIsGrey) {
    HeicFile file = heic_portrait();
    const Image grey = file.depth;
    file.depth.channels = 3;
    file.depth.samples.clear();
    for (const std::uint8_t sample : grey.samples)
        file.depth.samples.insert(file.depth.samples.end(), 3, sample);
    const auto clip = open(file.bytes());
    const RawFrame frame = frame_of(clip);
    EXPECT_GT(frame.depth.sample(20, 0), frame.depth.sample(19, 0));
    for (std::size_t row = 16; row < 20; ++row)  // so that chroma that four samples share shows it
        for (std::size_t x = 32; x < 36; ++x) file.depth.samples[(row * deep_wide + x) * 3] ^= 64U;
    EXPECT_TRUE(is_refused(open(file.bytes()), "its depth is coloured"));
}

/// As phones store it: tiles of one size, those at the right and the lower edge hang over.
TEST_F(Heic, PictureMayBeOfTiles) {
    for (const auto& [width, height] : {std::pair{128, 64}, {161, 115}, {63, 129}}) {
        HeicFile file = heic_portrait();
        file.tile_side = 64;
        file.colour = {width, height, 1, 3, {}};
        const auto shade = [](int x, int y) { return 20 + x + y / 2; };
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                file.colour.samples.insert(file.colour.samples.end(), 3,
                                           static_cast<std::uint8_t>(shade(x, y)));
        file.depth = {width, height, 1, 1, {}};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                file.depth.samples.push_back(static_cast<std::uint8_t>(x + y / 4));
        const auto clip = open(file.bytes());
        const RawFrame frame = frame_of(clip);
        ASSERT_EQ(frame.colour.width, width);
        ASSERT_EQ(frame.colour.height, height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                ASSERT_NEAR(frame.colour.sample(x, y, 1), shade(x, y), 2) << x << ' ' << y;
                ASSERT_EQ(frame.depth.sample(x, y), x + y / 4);
            }
    }
}

/// libheif would end the program where a layer is not there, and decode a tile of itself until it has no
/// stack.
TEST_F(Heic, LayersAndTilesOfThemselvesAreRefused) {
    const std::string bytes = heic_portrait().bytes();
    std::string layered = bytes;
    const auto kind = layered.find("hvc1", layered.find("infe"));
    ASSERT_NE(kind, std::string::npos);
    layered.replace(kind, 4, "iden");
    EXPECT_TRUE(is_refused(open(layered), "has a picture of layers"));
    const auto with_tile = [&](int picture, int tile) {
        const std::string made_of =
            big_endian(14, 4) + "dimg" + big_endian(picture, 2) + big_endian(1, 2) + big_endian(tile, 2);
        return bytes + big_endian(12 + made_of.size(), 4) + "iref" + big_endian(0, 4) + made_of;
    };
    EXPECT_TRUE(is_refused(open(with_tile(7, 7)), "or itself as one"));
    EXPECT_EQ(message(open(with_tile(7, 8))), "");
}

TEST_F(Heic, DisparitiesAreReciprocalMetresWhereTheyCanBe) {
    HeicFile file = heic_portrait();
    file.depth_xmp =
        apple_xmp("disparity", "0.8", "2.5", "<depthData:Accuracy>relative</depthData:Accuracy>");
    auto clip = open(file.bytes());
    ASSERT_EQ(message(clip), "");
    for (int v = 0; v < 256; ++v)
        EXPECT_NEAR((*clip)->scene().depth.depth(static_cast<std::uint16_t>(v)), 1 / (0.8 + v / 255.0 * 1.7),
                    1e-12);
    EXPECT_TRUE(is_noted(**clip, "right among each other"));
    EXPECT_FALSE(is_noted(**clip, "no scale"));
    file.depth_xmp = apple_xmp("depth", "0.5", "3");
    clip = open(file.bytes());
    ASSERT_EQ(message(clip), "");
    EXPECT_NEAR((*clip)->scene().depth.depth(51), 1, 1e-12);
    file.depth_xmp.clear();
    file.depth_sei = depth_info_sei({1, unsaid, unsaid, 0.5, 2});
    clip = open(file.bytes());
    ASSERT_EQ(message(clip), "");
    EXPECT_NEAR((*clip)->scene().depth.near, 0.5, 1e-6);
    EXPECT_NEAR((*clip)->scene().depth.far, 2, 1e-6);
    EXPECT_TRUE(is_noted(**clip, "guessed: its disparities are 1/metres"));
}

TEST_F(Heic, DepthWithoutAScaleIsAssumedAndSaid) {
    HeicFile file = heic_portrait();
    const std::string no_known_type = depth_info_sei({280, 0.5, 4, unsaid, unsaid});
    for (const auto& [sei, xmp] : {std::pair<std::string, std::string>{"", ""},
                                   {"", apple_xmp("disparity", "0", "1")},
                                   {depth_info_sei({1, unsaid, unsaid, -1, 1}), ""},
                                   {depth_info_sei({3, 0.5, 4, unsaid, unsaid}), "no <xmp"},
                                   {no_known_type, ""}}) {
        file.depth_sei = sei;
        file.depth_xmp = xmp;
        const auto clip = open(file.bytes());
        if (sei == no_known_type && !clip) {  // as libheif 1.23 reads it
            EXPECT_TRUE(is_refused(clip, "depth representation type"));
            continue;
        }
        const RawFrame frame = frame_of(clip);
        const Scene& scene = (*clip)->scene();
        EXPECT_TRUE(is_noted(**clip, "guessed: depth has no scale: its nearest is taken for 0.5 m"));
        const auto depth = [&](int x, int y) { return scene.depth.depth(frame.depth.sample(x, y)); };
        EXPECT_NEAR(depth(deep_wide - 1, deep_high - 1), 0.5, 1e-9);
        EXPECT_NEAR(depth(0, 0), 1.5, 1e-9);
        const double share = deep_at(30, 0) / static_cast<double>(deep_at(deep_wide - 1, deep_high - 1));
        EXPECT_NEAR(1 / depth(30, 0), 1 / 1.5 + share * (1 / 0.5 - 1 / 1.5), 1e-9);
    }
}

TEST_F(Heic, CameraIsAppleOrTheLensOrThePersons) {
    HeicFile file = heic_portrait();
    file.exif = exif_bytes(6, 28);  // its orientation is not that of HEIC, which has properties for it
    auto clip = open(file.bytes());
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->scene().width, deep_wide);
    EXPECT_NEAR((*clip)->scene().camera.fx, 28 * std::hypot(72, 48) / std::hypot(36, 24), 1e-4);
    clip = open(file.bytes(), 90);
    ASSERT_EQ(message(clip), "");
    EXPECT_NEAR((*clip)->scene().camera.fx, 36, 1e-9);
    std::string matrix;
    for (const char* number : {"720", "0", "0", "0", "700", "0", "359.5", "249.5", "1"})
        matrix += std::string("<rdf:li>") + number + "</rdf:li>";
    file.depth_xmp = apple_xmp("disparity", "0.8", "2.5",
                               "<depthData:IntrinsicMatrixReferenceWidth>720</depthData:"
                               "IntrinsicMatrixReferenceWidth><depthData:IntrinsicMatrix><rdf:Seq>" +
                                   matrix +
                                   "</rdf:Seq></depthData:IntrinsicMatrix><depthData:InverseLensDistortion"
                                   "Coefficients><rdf:Seq><rdf:li>1</rdf:li></rdf:Seq></depthData:InverseLens"
                                   "DistortionCoefficients><depthData:IntrinsicMatrixReferenceHeight>480</"
                                   "depthData:IntrinsicMatrixReferenceHeight>");
    clip = open(file.bytes());
    ASSERT_EQ(message(clip), "");
    const Camera& camera = (*clip)->scene().camera;
    EXPECT_NEAR(camera.fx, 72, 1e-9);
    EXPECT_NEAR(camera.fy, 70, 1e-9);
    EXPECT_NEAR(camera.cx, 35.5, 1e-9);
    EXPECT_NEAR(camera.cy, 24.5, 1e-9);
    EXPECT_FALSE(is_noted(**clip, "guessed"));
}

/// Turned by the file or, where it says nothing of depth, as the picture.
TEST_F(Heic, PictureAndDepthStandUpright) {
    for (int turn = 1; turn <= 8; ++turn)
        for (const bool is_of_both : {true, false}) {
            HeicFile file = heic_portrait();
            file.colour_turn = static_cast<heif_orientation>(turn);
            if (is_of_both) file.depth_turn = file.colour_turn;
            const auto clip = open(file.bytes());
            const RawFrame frame = frame_of(clip);
            const Scene& scene = (*clip)->scene();
            ASSERT_EQ(scene.width, turn > 4 ? deep_high : deep_wide) << turn;
            int corner[2] = {-1, -1};  // where the stored upper left one lies
            for (const int y : {0, scene.height - 1})
                for (const int x : {0, scene.width - 1})
                    if (frame.colour.sample(x, y, 0) > 150) {
                        corner[0] = x;
                        corner[1] = y;
                    }
            const bool right = turn == 2 || turn == 3 || turn == 6 || turn == 7,
                       bottom = turn == 3 || turn == 4 || turn == 7 || turn == 8;
            EXPECT_EQ(corner[0], right ? scene.width - 1 : 0) << turn;
            EXPECT_EQ(corner[1], bottom ? scene.height - 1 : 0) << turn;
            const auto nearness = [&](int x, int y) { return int{frame.depth.sample(x, y)}; };
            EXPECT_EQ(nearness(corner[0], corner[1]), 0) << turn << is_of_both;
            // Depth grows fastest along what were rows.
            const int inward_x = corner[0] == 0 ? 4 : scene.width - 5,
                      inward_y = corner[1] == 0 ? 4 : scene.height - 5;
            const int along_x = nearness(inward_x, corner[1]), along_y = nearness(corner[0], inward_y);
            EXPECT_EQ(along_x > along_y, turn <= 4) << turn << is_of_both;
        }
}

TEST_F(Heic, AvifIsReadAsWell) {
    HeicFile file = heic_portrait();
    file.format = heif_compression_AV1;
    const auto clip = open(file.bytes());
    const RawFrame frame = frame_of(clip);
    EXPECT_EQ((*clip)->tracks()[0].codec, "av1");
    EXPECT_GT(frame.depth.sample(deep_wide - 1, 0), frame.depth.sample(0, 0));
}

/// Their decoder's memory goes by these.
TEST_F(Heic, CodedSizesAreKnownBeforeAnythingIsDecoded) {
    HeicFile file = heic_portrait();
    for (const int bits : {8, 10}) {
        file.depth = heic_depth(bits);
        file.depth_bits = bits;
        const auto sizes = read_heif_coded_sizes(file.bytes());
        ASSERT_EQ(sizes.size(), 2U);
        EXPECT_EQ(sizes[0].width, 96U);
        EXPECT_EQ(sizes[0].height, 64U);
        EXPECT_EQ(sizes[1].width, 72U);
        EXPECT_EQ(sizes[1].height, 64U);  // 48 and what the encoder adds
    }
    EXPECT_TRUE(read_heif_coded_sizes(file.bytes().substr(0, 60)).empty());
}

TEST_F(Heic, WithoutDepthOrDamagedSaysSo) {
    HeicFile file = heic_portrait();
    file.has_depth = false;
    EXPECT_TRUE(is_refused(open(file.bytes()), "photo.heic: has no depth beside its picture: must be"));
    EXPECT_TRUE(is_refused(open(heic_portrait().bytes().substr(0, 200)), "is damaged or cut short: "));
}

}  // namespace
}  // namespace touchable::test
