#include <gtest/gtest.h>

#include <cmath>

#include "tests/clip/clip_fixture.hpp"
#include "tests/import/exif_bytes.hpp"
#include "tests/import/jpeg_with_xmp.hpp"
#include "tests/picture/encoded_picture.hpp"

namespace touchable::test {
namespace {

constexpr int photo_wide = 24, photo_high = 16, map_wide = 12, map_high = 8;

std::uint8_t map_at(int x, int y) {
    return static_cast<std::uint8_t>(20 * x + 3 * y);
}

/// Encoded by FFmpeg: grey of a depth map, or a picture that is bright in its upper left quarter.
std::string map_png() {
    return encoded("png", AV_PIX_FMT_GRAY8, map_wide, map_high, [](AVFrame& frame) {
        for (int y = 0; y < map_high; ++y)
            for (int x = 0; x < map_wide; ++x) frame.data[0][y * frame.linesize[0] + x] = map_at(x, y);
    });
}
std::string photo_jpeg() {
    return encoded("mjpeg", AV_PIX_FMT_YUVJ444P, photo_wide, photo_high, [](AVFrame& frame) {
        for (int plane = 0; plane < 3; ++plane)
            for (int y = 0; y < photo_high; ++y)
                for (int x = 0; x < photo_wide; ++x)
                    frame.data[plane][y * frame.linesize[plane] + x] =
                        plane > 0                                  ? 128
                        : x < photo_wide / 2 && y < photo_high / 2 ? 220
                                                                   : 40;
    });
}

/// A photo as Android writes it, put together piece by piece.
struct DynamicDepthFile {
    std::string map = map_png();
    std::string between, after;  ///< bytes before and behind the depth map
    std::string directory;       ///< empty: the usual one
    std::string properties =
        "DepthMap:Format='RangeInverse' DepthMap:Near='2' DepthMap:Far='10' DepthMap:Units='Meters' "
        "DepthMap:DepthURI='android/depthmap'";
    std::string camera;
    std::string exif;

    std::string bytes() const {
        const std::string usual =
            "<rdf:li><Container:Item Item:Mime='image/jpeg' Item:Length='0' Item:DataURI='primary_image'/>"
            "</rdf:li><rdf:li><Container:Item Item:Mime='video/mp4' Item:DataURI='movie' Item:Length='" +
            std::to_string(between.size()) +
            "'/></rdf:li><rdf:li rdf:parseType='Resource'><Item:Mime>image/png</Item:Mime><Item:Length>" +
            std::to_string(map.size()) +
            "</Item:Length><Item:DataURI>android/depthmap</Item:DataURI></rdf:li>";
        const std::string xmp =
            "<x:xmpmeta><rdf:RDF><rdf:Description><Device:Container><Container:Directory><rdf:Seq>" +
            (directory.empty() ? usual : directory) +
            "</rdf:Seq></Container:Directory></Device:Container><Device:Cameras><rdf:Seq><rdf:li>"
            "<Device:Camera><Camera:DepthMap " +
            properties + "/>" + (camera.empty() ? "" : "<Camera:ImagingModel " + camera + "/>") +
            "</Device:Camera></rdf:li></rdf:Seq></Device:Cameras></rdf:Description></rdf:RDF></x:xmpmeta>";
        const std::string photo = photo_jpeg();
        return photo.substr(0, 2) + (exif.empty() ? "" : exif_segment(exif)) + xmp_segment(xmp) +
               photo.substr(2) + between + map + after;
    }
};

class DynamicDepth : public ::testing::Test {
protected:
    Result<std::unique_ptr<ClipReader>> open(const std::string& bytes, const SourceDescription& known = {}) {
        std::filesystem::remove(folder / "photo.jpg");  // what is written over is waited for
        write_bytes(folder / "photo.jpg", bytes);
        return open_clip(folder / "photo.jpg", std::nullopt,
                         known == SourceDescription() ? std::nullopt : std::optional(known));
    }
    TemporaryFolder folder;
};

/// The first frame of a clip that opened.
RawFrame photo_frame(const Result<std::unique_ptr<ClipReader>>& clip) {
    EXPECT_EQ(message(clip), "");
    auto frames = read_all(**clip);
    EXPECT_EQ(message(frames), "");
    return frames->front();
}

TEST_F(DynamicDepth, MapIsFoundAfterThePictureByTheDirectory) {
    DynamicDepthFile file;
    for (const auto& [between, after] : {std::pair<std::string, std::string>{"", ""},
                                         {"a film\xff\xd8\xff", ""},
                                         {"", "what a maker adds"}}) {
        file.between = between;
        file.after = after;
        const auto clip = open(file.bytes());
        const RawFrame frame = photo_frame(clip);
        const Scene& scene = (*clip)->scene();
        ASSERT_EQ(scene.width, map_wide);
        for (int y = 0; y < map_high; ++y)
            for (int x = 0; x < map_wide; ++x) ASSERT_EQ(frame.depth.sample(x, y), map_at(x, y));
        for (int v = 0; v < 256; ++v)  // as the format's description has it
            EXPECT_NEAR(scene.depth.depth(static_cast<std::uint16_t>(v)),
                        10.0 * 2 / (10 - v / 255.0 * (10 - 2)), 1e-12);
        EXPECT_EQ(scene.metres_per_unit, 1);
        EXPECT_TRUE(is_noted(**clip, "guessed: the camera sees 60 degrees"));
        EXPECT_FALSE(is_noted(**clip, "metres")) << "said by the file";
        EXPECT_GT(frame.colour.sample(0, 0, 0), 150);
        EXPECT_LT(frame.colour.sample(map_wide - 1, 0, 0), 100);
    }
}

TEST_F(DynamicDepth, CameraIsThatOfTheFile) {
    DynamicDepthFile file;
    file.camera =
        "ImagingModel:FocalLengthX='30' ImagingModel:FocalLengthY='31' ImagingModel:ImageWidth='24' "
        "ImagingModel:ImageHeight='16' ImagingModel:PrincipalPointX='0.5' ImagingModel:PrincipalPointY='6.5'";
    const auto clip = open(file.bytes());
    ASSERT_EQ(message(clip), "");
    const Camera& camera = (*clip)->scene().camera;  // of a map of half the size
    EXPECT_DOUBLE_EQ(camera.fx, 15);
    EXPECT_DOUBLE_EQ(camera.fy, 15.5);
    EXPECT_DOUBLE_EQ(camera.cx, 5.5);
    EXPECT_DOUBLE_EQ(camera.cy, 3);
    EXPECT_FALSE(is_noted(**clip, "guessed"));
}

TEST_F(DynamicDepth, CameraIsThatOfThePersonOrOfTheLens) {
    DynamicDepthFile file;
    file.exif = exif_bytes(1, 26);
    const auto clip = open(file.bytes());
    ASSERT_EQ(message(clip), "");
    // 26 mm before a film of 36 x 24 mm: the diagonals correspond.
    EXPECT_NEAR((*clip)->scene().camera.fx, 26 * std::hypot(12, 8) / std::hypot(36, 24), 1e-4);
    EXPECT_TRUE(is_noted(**clip, "by its focal length, 26 mm in terms of 35 mm film (a scene file"));
    SourceDescription known;
    known.fov = 90;
    const auto wider = open(file.bytes(), known);
    ASSERT_EQ(message(wider), "");
    EXPECT_NEAR((*wider)->scene().camera.fx, 6, 1e-12);
    EXPECT_FALSE(is_noted(**wider, "guessed"));
    known = {};
    known.intrinsics = Intrinsics{20, 21, 5, 4};
    const auto exact = open(file.bytes(), known);
    ASSERT_EQ(message(exact), "");
    EXPECT_EQ((*exact)->scene().camera.cy, 4);
    EXPECT_EQ((*exact)->scene().depth.near, 2) << "depth is still the map's";
    known = {};
    known.metres_per_code = 0.001;
    EXPECT_TRUE(is_refused(open(file.bytes(), known), "a unit, a preset, range or planar say nothing of it"));
}

TEST_F(DynamicDepth, PortraitStandsUpright) {
    // Where the stored upper left corner comes to lie, and whether rows become columns.
    const struct {
        int exif;
        bool right, bottom, portrait;
    } cases[] = {{1, false, false, false}, {2, true, false, false}, {3, true, true, false},
                 {4, false, true, false},  {5, false, false, true}, {6, true, false, true},
                 {7, true, true, true},    {8, false, true, true}};
    for (const auto& turned : cases) {
        DynamicDepthFile file;
        file.exif = exif_bytes(turned.exif, 26, turned.exif % 2 == 0);
        file.camera =
            "ImagingModel:FocalLengthX='30' ImagingModel:FocalLengthY='31' ImagingModel:ImageWidth='24' "
            "ImagingModel:ImageHeight='16' ImagingModel:PrincipalPointX='9.5'";
        const auto clip = open(file.bytes());
        const RawFrame frame = photo_frame(clip);
        const Scene& scene = (*clip)->scene();
        ASSERT_EQ(scene.width, turned.portrait ? map_high : map_wide) << turned.exif;
        ASSERT_EQ(frame.colour.width, scene.width);
        const auto place = [](bool last, int length, int at) { return last ? length - 1 - at : at; };
        for (int along : {0, 3}) {  // stored column `along` of row 0
            const int x = place(turned.right, scene.width, turned.portrait ? 0 : along),
                      y = place(turned.bottom, scene.height, turned.portrait ? along : 0);
            EXPECT_EQ(frame.depth.sample(x, y), map_at(along, 0)) << turned.exif;
            EXPECT_GT(frame.colour.sample(x, y, 0), 150) << turned.exif;
        }
        const int far_x = place(!turned.right, scene.width, 0),
                  far_y = place(!turned.bottom, scene.height, 0);
        EXPECT_EQ(frame.depth.sample(far_x, far_y), map_at(map_wide - 1, map_high - 1)) << turned.exif;
        EXPECT_LT(frame.colour.sample(far_x, far_y, 0), 100) << turned.exif;
        // The axis goes through the same thing: stored column 9.5 of 24 is 4.5 of 12.
        EXPECT_DOUBLE_EQ(turned.portrait ? scene.camera.fy : scene.camera.fx, 15);
        if (turned.portrait)
            EXPECT_DOUBLE_EQ(scene.camera.cy, turned.bottom ? 11 - 4.5 : 4.5) << turned.exif;
        else
            EXPECT_DOUBLE_EQ(scene.camera.cx, turned.right ? 11 - 4.5 : 4.5) << turned.exif;
    }
}

TEST_F(DynamicDepth, WhatIsMissingOrWrongIsSaid) {
    DynamicDepthFile other, nowhere, cut, empty;
    other.properties =
        "DepthMap:Format='RangeInverse' DepthMap:Units='Diopters' DepthMap:Near='2' "
        "DepthMap:Far='10' DepthMap:DepthURI='android/depthmap'";
    nowhere.properties = "DepthMap:Format='RangeInverse' DepthMap:DepthURI='elsewhere'";
    empty.directory = "<rdf:li Item:DataURI='a'/><rdf:li Item:DataURI='android/depthmap' Item:Length='x'/>";
    cut.directory =
        "<rdf:li Item:DataURI='a'/><rdf:li Item:DataURI='android/depthmap' Item:Length='99999999999'/>";
    for (const auto& [file, word] :
         {std::pair{&other, "its DepthMap:Units is \"Diopters\": must be m (Meters) or mm"},
          {&nowhere, "must have the name of DepthMap:DepthURI, \"elsewhere\""},
          {&empty, "has no Item:Length"},
          {&cut, "has no depth map of 99999999999 bytes after its picture"}})
        EXPECT_TRUE(is_refused(open(file->bytes()), word));
    SourceDescription known;
    known.fov = 50;
    EXPECT_TRUE(is_refused(open(cut.bytes(), known), "has no depth map of")) << "no grey picture of depth";
    const std::string in_colour = encoded("mjpeg", AV_PIX_FMT_YUVJ444P, 16, 8, [](AVFrame& frame) {
        for (int plane = 0; plane < 3; ++plane)
            for (int k = 0; k < 8 * frame.linesize[plane]; ++k)
                frame.data[plane][k] = static_cast<std::uint8_t>(k % 100 + 40 * plane);
    });
    EXPECT_TRUE(is_refused(open(in_colour), "a JPEG needs a depth map (GDepth, Dynamic Depth)"));
    // A grey JPEG is depth itself.
    const std::string grey = encoded("mjpeg", AV_PIX_FMT_YUVJ444P, 16, 8, [](AVFrame& frame) {
        for (int plane = 0; plane < 3; ++plane)
            for (int k = 0; k < 8 * frame.linesize[plane]; ++k)
                frame.data[plane][k] = static_cast<std::uint8_t>(plane == 0 ? k % 100 : 128);
    });
    EXPECT_EQ(message(open(grey, known)), "");
    EXPECT_EQ(message(open(grey)), "");
}

}  // namespace
}  // namespace touchable::test
