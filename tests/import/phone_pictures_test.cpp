// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "engine/formats/depth_photo.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/import/heic_file.hpp"
#include "tests/picture/picture_bytes.hpp"
#include "tests/picture/results.hpp"
#include "tests/real_data.hpp"

namespace touchable::test {
namespace {

/// EXIF's TIFF structure, of an orientation and a focal length in terms of 35 mm film.
std::string exif_bytes(int orientation, int film_focal_length, bool is_big_endian = true) {
    const auto number = [&](std::uint64_t value, int bytes) {
        std::string text = big_endian(value, bytes);
        if (!is_big_endian) std::reverse(text.begin(), text.end());
        return text;
    };
    const auto entry = [&](int tag, int type, std::string value) {
        value.resize(4, '\0');
        return number(static_cast<std::uint64_t>(tag), 2) + number(static_cast<std::uint64_t>(type), 2) +
               number(1, 4) + value;
    };
    const auto directory = [&](const std::string& entries) {
        return number(entries.size() / 12, 2) + entries + number(0, 4);
    };
    const std::string first = entry(0x0112, 3, number(static_cast<std::uint64_t>(orientation), 2)) +
                              entry(0x8769, 4, number(8 + 6 + 24, 4));
    return (is_big_endian ? std::string("MM\0*", 4) : std::string("II*\0", 4)) + number(8, 4) +
           directory(first) +
           directory(entry(0x9000, 7, "0232") +
                     entry(0xa405, 3, number(static_cast<std::uint64_t>(film_focal_length), 2)));
}

std::string exif_segment(const std::string& tiff) {
    return segment('\xe1', std::string("Exif\0\0", 6) + tiff);
}

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
    return jpeg_of(photo_wide, photo_high, [](int x, int y, int plane) {
        return plane > 0 ? 128 : x < photo_wide / 2 && y < photo_high / 2 ? 220 : 40;
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
        return open_clip(folder / "photo.jpg", std::nullopt, known);
    }
    TemporaryFolder folder;
};

/// The first frame of a clip that opened.
RawFrame photo_frame(const Result<std::unique_ptr<ClipReader>>& clip) {
    EXPECT_EQ(message(clip), "");
    return must(read_all(**clip)).front();
}

TEST_F(DynamicDepth, FindsMapByDirectory) {
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

/// Planes in dioptres are those of metres; 0 is infinitely far.
TEST_F(DynamicDepth, TakesDioptres) {
    DynamicDepthFile file;
    const auto with = [&](const std::string& format, const std::string& near, const std::string& far) {
        file.properties = "DepthMap:Format='" + format + "' DepthMap:Near='" + near + "' DepthMap:Far='" +
                          far + "' DepthMap:Units='Diopters' DepthMap:DepthURI='android/depthmap'";
        return must(open(file.bytes()))->scene().depth;
    };
    for (int v = 0; v < 256; ++v) {
        const auto code = static_cast<std::uint16_t>(v);
        const double share = v / 255.0, metres = 10.0 * 2 / (10 - share * (10 - 2));
        EXPECT_NEAR(with("RangeInverse", "0.5", "0.1").depth(code), metres, 1e-12);
        EXPECT_NEAR(with("RangeInverse", "0.1", "0.5").depth(code), 10.0 * 2 / (2 + share * (10 - 2)), 1e-12);
        EXPECT_NEAR(with("RangeLinear", "0.5", "0.1").depth(code), 2 + 8 * share, 1e-12);
        EXPECT_NEAR(1 / with("RangeInverse", "2", "0").depth(code), 2 * (1 - share), 1.1e-3);
    }
}

TEST_F(DynamicDepth, TakesCameraOfFile) {
    DynamicDepthFile file;
    file.camera =
        "ImagingModel:FocalLengthX='30' ImagingModel:FocalLengthY='31' ImagingModel:ImageWidth='24' "
        "ImagingModel:ImageHeight='16' ImagingModel:PrincipalPointX='0.5' ImagingModel:PrincipalPointY='6.5'";
    const auto clip = must(open(file.bytes()));
    const Camera& camera = clip->scene().camera;  // of a map of half the size
    EXPECT_EQ(camera, (Camera{15, 15.5, 5.5, 3}));
    EXPECT_FALSE(is_noted(*clip, "guessed"));
}

TEST_F(DynamicDepth, TakesStatedCameraOrLens) {
    DynamicDepthFile file;
    file.exif = exif_bytes(1, 26);
    const auto clip = must(open(file.bytes()));
    // 26 mm before a film of 36 x 24 mm: the diagonals correspond.
    EXPECT_NEAR(clip->scene().camera.fx, 26 * std::hypot(12, 8) / std::hypot(36, 24), 1e-4);
    EXPECT_TRUE(is_noted(*clip, "by its focal length, 26 mm in terms of 35 mm film (a scene file"));
    SourceDescription known;
    known.fov = 90;
    const auto wider = must(open(file.bytes(), known));
    EXPECT_NEAR(wider->scene().camera.fx, 6, 1e-12);
    EXPECT_FALSE(is_noted(*wider, "guessed"));
    known = {};
    known.intrinsics = Intrinsics{20, 21, 5, 4};
    const auto exact = must(open(file.bytes(), known));
    EXPECT_EQ(exact->scene().camera.cy, 4);
    EXPECT_EQ(exact->scene().depth.near, 2) << "depth is still the map's";
    known = {};
    known.metres_per_code = 0.001;
    EXPECT_TRUE(is_refused(open(file.bytes(), known), "a unit, a preset, range or planar say nothing of it"));
}

TEST_F(DynamicDepth, StandsUpright) {
    // The place of the stored upper left corner, and whether rows become columns.
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

TEST_F(DynamicDepth, NamesFaults) {
    DynamicDepthFile other, nowhere, cut, empty;
    other.properties =
        "DepthMap:Format='RangeInverse' DepthMap:Units='Feet' DepthMap:Near='2' "
        "DepthMap:Far='10' DepthMap:DepthURI='android/depthmap'";
    nowhere.properties = "DepthMap:Format='RangeInverse' DepthMap:DepthURI='elsewhere'";
    empty.directory = "<rdf:li Item:DataURI='a'/><rdf:li Item:DataURI='android/depthmap' Item:Length='x'/>";
    cut.directory =
        "<rdf:li Item:DataURI='a'/><rdf:li Item:DataURI='android/depthmap' Item:Length='99999999999'/>";
    for (const auto& [file, word] :
         {std::pair{&other, "its DepthMap:Units is \"Feet\": must be m (Meters), mm or Diopters"},
          {&nowhere, "must have the name of DepthMap:DepthURI, \"elsewhere\""},
          {&empty, "has no Item:Length"},
          {&cut, "has no depth map of 99999999999 bytes after its picture"}})
        EXPECT_TRUE(is_refused(open(file->bytes()), word));
    const SourceDescription known = stated(&SourceDescription::fov, 50);
    EXPECT_TRUE(is_refused(open(cut.bytes(), known), "has no depth map of")) << "no grey picture of depth";
    const auto jpeg = [](bool is_grey) {
        return jpeg_of(16, 8, [&](int x, int y, int plane) {
            return is_grey && plane > 0 ? 128 : (16 * y + x) % 100 + 40 * plane;
        });
    };
    EXPECT_TRUE(is_refused(open(jpeg(false)), "a JPEG needs a depth map (GDepth, Dynamic Depth)"));
    // A grey JPEG is depth itself.
    EXPECT_EQ(message(open(jpeg(true), known)), "");
    EXPECT_EQ(message(open(jpeg(true))), "");
}

constexpr int deep_photo_wide = 12, deep_photo_high = 10;

/// A depth map as phones store it: three channels alike, and alpha.
std::string depth_png(int odd_one_out = -1) {
    return rgba_png(deep_photo_wide, deep_photo_high, [&](int x, int y, int c) {
        const bool is_odd = c == 1 && y * deep_photo_wide + x == odd_one_out;
        return c == 3 ? 255 : map_at(x, y) + (is_odd ? 1 : 0);
    });
}

/// A plain picture; half the depth map's size where asked.
std::string plain_jpeg(int divisor = 1) {
    return jpeg_of(deep_photo_wide / divisor, deep_photo_high / divisor, [](int, int, int plane) {
        return plane == 0 ? 150 : plane == 1 ? 100 : 140;
    });
}

/// Most pictures after the first, such as a gain map, are no depth.
TEST_F(DynamicDepth, FindsApplesMapAmongPictures) {
    const auto with_xmp = [](const std::string& type) {
        const std::string jpeg = photo_jpeg();
        return jpeg.substr(0, 2) +
               xmp_segment("<x><rdf:Description apdi:AuxiliaryImageType='" + type +
                           "' apdi:FloatMinValue='0.5' apdi:FloatMaxValue='2'/></x>") +
               jpeg.substr(2);
    };
    const std::string gain = with_xmp("urn:com:apple:photo:2020:aux:hdrgainmap"), map = with_xmp("disparity");
    const auto clip = must(open(photo_jpeg() + gain + "\xff\xff between" + map + gain));
    EXPECT_EQ(clip->scene().depth.near, 0.5);
    EXPECT_EQ(clip->scene().depth.far, 2);
    EXPECT_TRUE(clip->scene().depth.near_is_high);
    EXPECT_FALSE(is_noted(*clip, "guessed: depth"));
    EXPECT_EQ(message(open(photo_jpeg() + gain)), "") << "a grey JPEG is depth itself";
    EXPECT_TRUE(is_refused(open(plain_jpeg() + gain), "a JPEG needs a depth map"));
}

TEST_F(DynamicDepth, NamesSamsungsTrailer) {
    const auto with = [&](const std::string& name) { return open(plain_jpeg() + name + "SEFH, SEFT"); };
    const std::string photo = (folder / "photo").string();
    EXPECT_TRUE(is_refused(with("DualShot_DepthMap_1"), "exiftool -b -DepthMapTiff " + photo + ".jpg > " +
                                                            photo + "_depth.tif, then: touchable play " +
                                                            photo));
    EXPECT_TRUE(is_refused(with("SingleShot_DepthMap_1"), "exiftool -b -SingleShotDepthMapTiff "));
    EXPECT_TRUE(is_refused(with("Image_UTC_Data"), "a JPEG needs a depth map"));
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

using GdepthJpeg = FolderTest;

TEST_F(GdepthJpeg, OpensAsOneFrame) {
    auto clip = must(open_bytes(folder, Gdepth().file()));
    const Scene& scene = clip->scene();
    EXPECT_EQ(scene.name, "still");
    EXPECT_EQ(scene.width, deep_photo_wide);
    EXPECT_EQ(scene.height, deep_photo_high);
    EXPECT_EQ(scene.metres_per_unit, 1.0);
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::planar);
    for (int v = 0; v < 256; ++v)  // as the format's description has it
        EXPECT_NEAR(scene.depth.depth(static_cast<std::uint16_t>(v)), 10.0 * 2 / (10 - v / 255.0 * (10 - 2)),
                    1e-12);
    EXPECT_TRUE(is_noted(*clip, "guessed: lengths are metres"));
    EXPECT_TRUE(is_noted(*clip,
                         "guessed: the camera sees 60 degrees from left to right; if it sees 70, all shapes "
                         "are 18 % too narrow (a scene file"));
    EXPECT_FALSE(is_noted(*clip, "resampled"));
    EXPECT_EQ(clip->frame_count(), 1);
    ASSERT_EQ(clip->tracks().size(), 2U);
    EXPECT_EQ(clip->tracks()[0].pixel_format, "rgba");
    for (int round = 0; round < 2; ++round) {
        const auto frames = must(read_all(*clip));
        ASSERT_EQ(frames.size(), 1U);
        const RawFrame& frame = frames.front();
        EXPECT_EQ(frame.time_ns, 0);
        ASSERT_EQ(frame.depth.channels, 1);
        for (int y = 0; y < deep_photo_high; ++y)
            for (int x = 0; x < deep_photo_wide; ++x) {
                ASSERT_EQ(frame.depth.sample(x, y), map_at(x, y));
                ASSERT_EQ(frame.colour.sample(x, y, 0), frame.colour.sample(0, 0, 0));
            }
        EXPECT_GT(frame.colour.sample(0, 0, 0), frame.colour.sample(0, 0, 2));  // more red than blue
        ASSERT_EQ(message(clip->rewind()), "");
    }
}

TEST_F(GdepthJpeg, StatesUnitsAndSemantics) {
    Gdepth still;
    still.attributes =
        "GDepth:Format='RangeLinear' GDepth:Near='200' GDepth:Far='1220' GDepth:Units='mm' "
        "GDepth:MeasureType='OpticRay'";
    auto clip = must(open_bytes(folder, still.file()));
    const Scene& scene = clip->scene();
    EXPECT_EQ(scene.metres_per_unit, 0.001);
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::range);
    for (int v = 0; v < 256; ++v)
        EXPECT_DOUBLE_EQ(scene.depth.depth(static_cast<std::uint16_t>(v)), 200.0 + 4 * v);
    EXPECT_FALSE(is_noted(*clip, "metres"));
}

TEST_F(GdepthJpeg, ReadsSixteenBits) {
    Samples memory;
    const PlaneView plane = test_plane(memory, deep_photo_wide, deep_photo_high, 2, 1, 65535, 3, true);
    ASSERT_EQ(message(write_png(folder / "depth.png", plane)), "");
    Gdepth still;
    still.data = encode_base64(read_bytes(folder / "depth.png")).insert(6, " \r\n\t");
    auto clip = must(open_bytes(folder, still.file()));
    EXPECT_EQ(clip->scene().depth.code_max, 65535);
    const auto frames = read_all(*clip);
    EXPECT_TRUE(same_plane(frames->front().depth, plane));
}

TEST_F(GdepthJpeg, ResamplesColourWithNote) {
    Gdepth still;
    still.picture = plain_jpeg(2);
    auto clip = must(open_bytes(folder, still.file()));
    EXPECT_TRUE(is_noted(*clip, "colour is 6x5: resampled"));
    EXPECT_EQ((*read_all(*clip)).front().colour.width, deep_photo_wide);
}

TEST_F(GdepthJpeg, GivesWayToSceneFile) {
    Scene scene = small_scene(deep_photo_wide, deep_photo_high);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 3;
    scene.depth.near = 0;
    scene.depth.far = 3 * 255;
    SceneDescription without_far(scene);
    without_far.unstated.far = true;
    write_bytes(folder / "scene.json", scene_to_json(without_far));
    write_bytes(folder / "still.jpg", Gdepth().file());
    auto clip = must(open_clip(folder / "still.jpg", folder / "scene.json"));
    EXPECT_EQ(clip->scene().name, "small");
    EXPECT_FALSE(is_noted(*clip, "guessed"));
    const double deepest = 3.0 * map_at(deep_photo_wide - 1, deep_photo_high - 1);
    EXPECT_DOUBLE_EQ(clip->scene().depth.far, 1.05 * deepest);
}

TEST_F(GdepthJpeg, LeavesNothingToGuess) {
    write_bytes(folder / "portrait.jpg", Gdepth().file());
    EXPECT_TRUE(is_refused(guess_clip(folder / "portrait.jpg", {}), "touchable convert "));
    write_bytes(folder / "plain.jpg", plain_jpeg());
    EXPECT_TRUE(is_refused(guess_clip(folder / "plain.jpg", {}), "is in colour"));
}

TEST_F(GdepthJpeg, NamesFaults) {
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
        {with_data("Z"), "GDepth:Data is not base64"},
        {with_data("Zg="), "GDepth:Data is not base64"},
        {with_data("Zg==Zg=="), "GDepth:Data is not base64"},
        {with_data("Z=g="), "GDepth:Data is not base64"},
        {with_data("Zm9-"), "GDepth:Data is not base64"},
        {with_data("Zg"), "GDepth:Data is not base64"},
        {with_data("Zg==="), "GDepth:Data is not base64"},
        {with_data("===="), "GDepth:Data is not base64"},
        {with_data("="), "GDepth:Data is not base64"},
        {with_data("Zm9v!"), "GDepth:Data is not base64"},
        {with_data("Zm&v"), "GDepth:Data is not base64"},
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
        EXPECT_TRUE(is_refused(clip, word)) << word << " in: " << message(clip);
    }
}

struct Still {
    const char* name;
    int width, height;
    double near, far;
};

class RealGdepth : public ::testing::TestWithParam<Still> {};

TEST_P(RealGdepth, HasDepthsInMetres) {
    const auto file = real_data("stills/lensblur") / (std::string(GetParam().name) + ".jpg");
    TOUCHABLE_NEEDS_DATA(file);
    auto clip = must(open_clip(file));
    const Scene& scene = clip->scene();
    EXPECT_EQ(scene.width, GetParam().width);
    EXPECT_EQ(scene.height, GetParam().height);
    EXPECT_NEAR(scene.depth.near, GetParam().near, 0.001);
    EXPECT_NEAR(scene.depth.far, GetParam().far, 0.001);
    EXPECT_EQ(scene.depth.depth(0), scene.depth.near);
    const auto frames = must(read_all(*clip));
    const RawFrame& frame = frames.front();
    // A figure in the middle stands before a background at the top.
    const auto depth = [&](int x, int y) { return scene.depth.depth(frame.depth.sample(x, y)); };
    const double figure = depth(scene.width / 2, scene.height / 2), background = depth(scene.width / 2, 10);
    EXPECT_LT(figure * 1.3, background);
    EXPECT_EQ(frame.colour.width, scene.width);
}

TEST(Base64, DecodesExamplesOfRfc4648) {
    EXPECT_EQ(decode_base64(""), "");
    EXPECT_EQ(decode_base64("Zg=="), "f");
    EXPECT_EQ(decode_base64("Zm8="), "fo");
    EXPECT_EQ(decode_base64("Zm9v"), "foo");
    EXPECT_EQ(decode_base64("Zm9vYg=="), "foob");
    EXPECT_EQ(decode_base64(" Zm9v\r\nYm\tFy\n"), "foobar");
}

INSTANTIATE_TEST_SUITE_P(Lensblur, RealGdepth,
                         ::testing::Values(Still{"greek-helmet", 2048, 1536, 4.484, 19.309},
                                           Still{"yamasa-maneki-neko", 1536, 2048, 8.291, 40.795}),
                         [](const auto& test) { return test.index == 0 ? "Helmet" : "Neko"; });

TEST(Xmp, ReadsAttributesAndElements) {
    const auto entries = parse_xmp_entries(R"(<?xpacket begin="" id="x>"?><!-- a="1" <b> -->
        <x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:Description a:One = "1" a:Two='it"s'
          a:Long="AB&amp;"><a:Three>3.5</a:Three><a:Empty/><a:Nested><b:Li>4</b:Li></a:Nested>
        </rdf:Description></x:xmpmeta><?xpacket end="w"?>)");
    ASSERT_TRUE(entries);
    std::map<std::string, std::string> properties;
    for (const XmpEntry& entry : *entries)
        if (entry.value) properties[entry.name] = *entry.value;
    const std::map<std::string, std::string> expected{
        {"xmlns:x", "adobe:ns:meta/"}, {"a:One", "1"},     {"a:Two", "it\"s"},
        {"a:Long", "AB&amp;"},         {"a:Three", "3.5"}, {"b:Li", "4"}};
    EXPECT_EQ(properties, expected);
}

TEST(Xmp, RefusesBrokenTags) {
    for (const char* text :
         {"<", "<a", "<a b", "<a b=", "<a b=c>", "<a b=\"c>", "<a b=\"c\"", "<a ='c'>", "<!-- a", "<? a",
          "</a", "< a>", "<a <b>>", "<a \"b\">", "<a>", "<a></b>", "<a><b></a></b>"})
        EXPECT_FALSE(parse_xmp_entries(text)) << text;
    EXPECT_TRUE(parse_xmp_entries("")->empty());
    EXPECT_TRUE(parse_xmp_entries("no tag at all")->empty());
}

TEST(Xmp, TakesElementsOfAnyDepth) {
    constexpr std::size_t depth = 200'000;  // far more than a stack has room for
    std::string text;
    for (std::size_t k = 0; k < depth; ++k) text += "<a>";
    text += "1";
    for (std::size_t k = 0; k < depth; ++k) text += "</a>";
    const auto entries = parse_xmp_entries(text);
    ASSERT_TRUE(entries);
    EXPECT_EQ(entries->size(), depth + 1);
    EXPECT_EQ(entries->back().value, "1");
}

std::string packet(const std::string& attributes) {
    return "<x:xmpmeta><rdf:Description " + attributes + "/></x:xmpmeta>";
}
std::string main_packet() {
    return xmp_segment(packet(std::string("a:Near='1' xmpNote:HasExtendedXMP='") + guid + "'"));
}

TEST(JpegXmp, JoinsPiecesInAnyOrder) {
    const std::string extended = packet("a:Data='" + std::string(1000, 'Q') + "' a:Near='2'");
    const std::string first = extension_segment(guid, extended, 0, 400);
    const std::string second = extension_segment(guid, extended, 400, extended.size());
    const std::string foreign = extension_segment(std::string(32, 'F'), packet("a:Other='1'"), 0, 10);
    for (const std::string& segments :
         {main_packet() + first + second, second + foreign + main_packet() + first,
          segment('\xe0', "JFIF") + foreign + second + first + main_packet() + "\xff"}) {
        const auto xmp = must(read_jpeg_xmp(jpeg_around(segments), "x.jpg"));
        EXPECT_EQ(*xmp_value(xmp, "a:Data"), std::string(1000, 'Q'));
        EXPECT_EQ(*xmp_value(xmp, "a:Near"), "1") << "the packet itself wins";
        EXPECT_FALSE(xmp_value(xmp, "a:Other"));
    }
}

TEST(JpegXmp, IsEmptyWithoutSegments) {
    for (const std::string& segments : {std::string(), segment('\xe1', std::string("Exif\0\0MM", 8)),
                                        extension_segment(guid, packet("a:Near='2'"), 0, 10)}) {
        const auto xmp = must(read_jpeg_xmp(jpeg_around(segments), "x.jpg"));
        EXPECT_TRUE(xmp.empty());
    }
}

TEST(JpegXmp, RefusesPiecesThatDisagree) {
    const std::string extended = packet("a:Data='" + std::string(100, 'Q') + "'");
    const auto piece = [&](std::size_t from, std::size_t to) {
        return extension_segment(guid, extended, from, to);
    };
    const std::size_t end = extended.size();
    const std::pair<std::string, const char*> cases[] = {
        {"", "that is not in the file"},
        {extension_segment(std::string(32, 'F'), extended, 0, end), "that is not in the file"},
        {segment('\xe1', std::string(extension_header()) + guid + "1234567"), "that is not in the file"},
        {piece(0, 50), "is 50 bytes, not"},
        {piece(50, end), "a gap at byte 0"},
        {piece(0, 50) + piece(60, end), "a gap at byte 50"},
        {piece(0, 50) + piece(40, end), "overlap at byte 40"},
        {piece(0, end) + piece(0, end), "overlap at byte 0"},
        {piece(0, end) + piece(end, end) + extension_segment(guid, extended + "x", end, end), "disagree"},
        {extension_segment(guid, extended, 0, 50, 0xFFFFFFFF), "is 50 bytes, not 4294967295"},
        {extension_segment(guid, "<a b=", 0, 5), "not well-formed"},
    };
    for (const auto& [segments, word] : cases) {
        const auto xmp = read_jpeg_xmp(jpeg_around(main_packet() + segments), "x.jpg");
        ASSERT_FALSE(xmp) << word;
        EXPECT_EQ(xmp.error().kind, ErrorKind::input);
        EXPECT_TRUE(message(xmp).starts_with("x.jpg: ")) << message(xmp);
        EXPECT_TRUE(is_refused(xmp, word));
    }
}

constexpr int heic_wide = 96, heic_high = 64, deep_wide = 72, deep_high = 48;
constexpr double unsaid = std::numeric_limits<double>::quiet_NaN();

int deep_at(int x, int y) {
    return 3 * x + y / 4;
}

/// Bright in its upper left quarter.
Image heic_colour() {
    return made_image(heic_wide, heic_high, 1, 3,
                      [](int x, int y, int) { return x < heic_wide / 2 && y < heic_high / 2 ? 220 : 40; });
}
Image heic_depth(int bits = 8) {
    return made_image(deep_wide, deep_high, bits > 8 ? 2 : 1, 1,
                      [&](int x, int y, int) { return deep_at(x, y) * (bits > 8 ? 4 : 1); });
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
        return open_clip(folder / "photo.heic", std::nullopt, stated(&SourceDescription::fov, fov));
    }
    TemporaryFolder folder;
};

TEST_F(Heic, ScalesDepthBetweenPlanes) {
    HeicFile file = heic_portrait();
    file.depth_sei = depth_info_sei({0, 0.5, 4, unsaid, unsaid});
    auto clip = open(file.bytes());
    const RawFrame frame = photo_frame(clip);
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

TEST_F(Heic, ReadsTenBits) {
    HeicFile file = heic_portrait();
    file.depth = heic_depth(10);
    file.depth_bits = 10;
    file.depth_sei = depth_info_sei({0, 0.5, 4, unsaid, unsaid});
    const auto clip = open(file.bytes());
    const RawFrame frame = photo_frame(clip);
    EXPECT_EQ((*clip)->scene().depth.code_max, 1023);
    for (int x = 0; x < deep_wide; ++x) ASSERT_EQ(frame.depth.sample(x, 7), 4 * deep_at(x, 7));
}

TEST_F(Heic, ReadsGreyStoredAsColour) {
    HeicFile file = heic_portrait();
    file.depth = made_image(deep_wide, deep_high, 1, 3, [](int x, int y, int) { return deep_at(x, y); });
    const auto clip = open(file.bytes());
    const RawFrame frame = photo_frame(clip);
    EXPECT_GT(frame.depth.sample(20, 0), frame.depth.sample(19, 0));
    for (std::size_t row = 16; row < 20; ++row)  // so that chroma that four samples share shows it
        for (std::size_t x = 64; x < 68; ++x) file.depth.samples[(row * deep_wide + x) * 3] ^= 64U;
    EXPECT_TRUE(is_refused(open(file.bytes()), "its depth is coloured"));
}

/// As phones store it: tiles of one size, those at the right and the lower edge hang over.
TEST_F(Heic, ReadsTiles) {
    for (const auto& [width, height] : {std::pair{128, 64}, {161, 115}, {63, 129}}) {
        HeicFile file = heic_portrait();
        file.tile_side = 64;
        const auto shade = [](int x, int y) { return 20 + x + y / 2; };
        file.colour = made_image(width, height, 1, 3, [&](int x, int y, int) { return shade(x, y); });
        file.depth = made_image(width, height, 1, 1, [](int x, int y, int) { return x + y / 4; });
        const auto clip = open(file.bytes());
        const RawFrame frame = photo_frame(clip);
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
TEST_F(Heic, RefusesLayersAndRecursiveTiles) {
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

TEST_F(Heic, TakesDisparitiesAsReciprocalMetres) {
    HeicFile file = heic_portrait();
    file.depth_xmp =
        apple_xmp("disparity", "0.8", "2.5", "<depthData:Accuracy>relative</depthData:Accuracy>");
    auto clip = must(open(file.bytes()));
    for (int v = 0; v < 256; ++v)
        EXPECT_NEAR(clip->scene().depth.depth(static_cast<std::uint16_t>(v)), 1 / (0.8 + v / 255.0 * 1.7),
                    1e-12);
    EXPECT_TRUE(is_noted(*clip, "right among each other"));
    EXPECT_FALSE(is_noted(*clip, "no scale"));
    file.depth_xmp = apple_xmp("depth", "0.5", "3");
    clip = must(open(file.bytes()));
    EXPECT_NEAR(clip->scene().depth.depth(51), 1, 1e-12);
    file.depth_xmp.clear();
    file.depth_sei = depth_info_sei({1, unsaid, unsaid, 0.5, 2});
    clip = must(open(file.bytes()));
    EXPECT_NEAR(clip->scene().depth.near, 0.5, 1e-6);
    EXPECT_NEAR(clip->scene().depth.far, 2, 1e-6);
    EXPECT_TRUE(is_noted(*clip, "guessed: its disparities are 1/metres"));
}

TEST_F(Heic, AssumesMissingScaleWithNote) {
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
        const RawFrame frame = photo_frame(clip);
        const Scene& scene = (*clip)->scene();
        EXPECT_TRUE(is_noted(**clip, "guessed: depth has no scale: its nearest is taken for 0.5 m"));
        const auto depth = [&](int x, int y) { return scene.depth.depth(frame.depth.sample(x, y)); };
        EXPECT_NEAR(depth(deep_wide - 1, deep_high - 1), 0.5, 1e-9);
        EXPECT_NEAR(depth(0, 0), 1.5, 1e-9);
        const double share = deep_at(30, 0) / static_cast<double>(deep_at(deep_wide - 1, deep_high - 1));
        EXPECT_NEAR(1 / depth(30, 0), 1 / 1.5 + share * (1 / 0.5 - 1 / 1.5), 1e-9);
    }
}

TEST_F(Heic, TakesStatedCameraOrLens) {
    HeicFile file = heic_portrait();
    file.exif = exif_bytes(6, 28);  // its orientation is not that of HEIC, which has properties for it
    auto clip = must(open(file.bytes()));
    EXPECT_EQ(clip->scene().width, deep_wide);
    EXPECT_NEAR(clip->scene().camera.fx, 28 * std::hypot(72, 48) / std::hypot(36, 24), 1e-4);
    clip = must(open(file.bytes(), 90));
    EXPECT_NEAR(clip->scene().camera.fx, 36, 1e-9);
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
    clip = must(open(file.bytes()));
    const Camera& camera = clip->scene().camera;
    EXPECT_NEAR(camera.fx, 72, 1e-9);
    EXPECT_NEAR(camera.fy, 70, 1e-9);
    EXPECT_NEAR(camera.cx, 35.5, 1e-9);
    EXPECT_NEAR(camera.cy, 24.5, 1e-9);
    EXPECT_FALSE(is_noted(*clip, "guessed"));
}

/// Turned by the file or, where it says nothing of depth, as the picture.
TEST_F(Heic, StandsUpright) {
    for (int turn = 1; turn <= 8; ++turn)
        for (const bool is_of_both : {true, false}) {
            HeicFile file = heic_portrait();
            file.colour_turn = static_cast<heif_orientation>(turn);
            if (is_of_both) file.depth_turn = file.colour_turn;
            const auto clip = open(file.bytes());
            const RawFrame frame = photo_frame(clip);
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

TEST_F(Heic, ReadsAvif) {
    HeicFile file = heic_portrait();
    file.format = heif_compression_AV1;
    const auto clip = open(file.bytes());
    const RawFrame frame = photo_frame(clip);
    EXPECT_EQ((*clip)->tracks()[0].codec, "av1");
    EXPECT_GT(frame.depth.sample(deep_wide - 1, 0), frame.depth.sample(0, 0));
}

/// Their decoder's memory goes by these.
TEST_F(Heic, KnowsCodedSizesBeforeDecoding) {
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

TEST_F(Heic, RefusesMissingDepthAndDamage) {
    HeicFile file = heic_portrait();
    file.has_depth = false;
    EXPECT_TRUE(is_refused(open(file.bytes()), "photo.heic: has no depth beside its picture: must be"));
    EXPECT_TRUE(is_refused(open(heic_portrait().bytes().substr(0, 200)), "is damaged or cut short: "));
}

}  // namespace
}  // namespace touchable::test
