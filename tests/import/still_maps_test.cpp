// SPDX-License-Identifier: Apache-2.0
// Maps that serve a whole clip: pictures, and surfaces of X3D and glTF, whose texts are written here by hand.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "engine/clip/clip.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/touch_maps.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip_notes.hpp"
#include "tests/limits.hpp"
#include "tests/picture/results.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

/// 2x2, grey: 0, 85, 170, 255; zlib and base64 of Python's library wrote it.
const std::string grey_png =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAAAAABX3VL4AAAADklEQVR4nGNgCGVY9R8AA60B/2f7ygkAAAAASUVORK5CYII=";
constexpr std::array<int, 4> grey_png_codes{0, 85, 170, 255};

struct Picture {
    int width, height;
    int channels = 1, bytes = 1;
};
/// Writes one of which no two samples beside each other are alike, and gives its samples in a row.
std::vector<int> write_picture(const std::filesystem::path& file, const Picture& of, int salt = 1) {
    std::vector<int> codes;
    write_in_folder(file, made_image(of.width, of.height, of.bytes, of.channels, [&](int, int, int) {
                        codes.push_back((static_cast<int>(codes.size()) * 61 + salt * 17) %
                                        (of.bytes == 2 ? 65536 : 256));
                        return codes.back();
                    }));
    return codes;
}

std::vector<int> channel_of(const PlaneView& plane, int channel) {
    std::vector<int> codes;
    for (int y = 0; y < plane.height; ++y)
        for (int x = 0; x < plane.width; ++x) codes.push_back(plane.sample(x, y, channel));
    return codes;
}

void expect_range(const PropertyRange& range, double least, double most) {
    EXPECT_NEAR(range.min, least, 1e-12);
    EXPECT_NEAR(range.max, most, 1e-12);
}

std::string surface(const std::string& fields, const std::string& maps) {
    return "<?xml version='1.0' encoding='utf-8'?>\n<X3D profile='H3DAPI' "
           "version='1.4'><Scene><Shape><Appearance>"
           "<Material/><HapticTexturesSurface " +
           fields + ">" + maps + "</HapticTexturesSurface></Appearance><Box/></Shape></Scene></X3D>\n";
}
std::string map(const std::string& name, const std::string& url) {
    return "<ImageTexture containerField='" + name + "Map' url='" + url + "'/>";
}

/// glTF with one haptic material; `more` are members of the root.
std::string material(const std::string& properties, const std::string& more) {
    return R"({"asset": {"version": "2.0"}, "extensionsUsed": ["MPEG_haptic_material"], "extensions":
        {"MPEG_haptic_material": {"materials": [{)" +
           properties + R"(}]}}, )" + more + "}";
}
std::string entry(int texture, const std::string& type = "High_Resolution", const std::string& more = "") {
    return R"({"texture": {"index": )" + std::to_string(texture) + R"(}, "type": ")" + type + "\"" + more +
           "}";
}
const std::string two_textures =
    R"("textures": [{"source": 1}, {"source": 0}], "images": [{"uri": "b%20map.png"}, {"uri": "a.png"}])";

class StillMaps : public ::testing::Test {
protected:
    Result<StillPlane> read(const std::string& name, const std::string& text) {
        write_bytes(folder / name, text);
        scene = small_scene(4, 3);
        return read_haptic_map(folder / name, scene);
    }
    void expect_refused(const std::string& name, const std::string& text, const std::string& words) {
        const auto map = read(name, text);
        ASSERT_FALSE(map) << text;
        EXPECT_TRUE(has_words(map.error().message, words));
        EXPECT_EQ(map.error().message.find('\n'), std::string::npos);
    }
    TemporaryFolder folder;
    Scene scene;
};

TEST_F(StillMaps, ReadX3dRanges) {
    const auto stiff = write_picture(folder / "stiff.png", {4, 3}, 1),
               slide = write_picture(folder / "s.png", {4, 3}, 2);
    const auto found =
        read("a.x3d",
             surface("minStiffness='0.1' maxStiffness=' +0.9 ' maxDynamicFriction='.7' useRelativeValues=''",
                     map("stiffness", "\"stiff.png\"") + map("dynamicFriction", "s.png")));
    ASSERT_EQ(message(found), "");
    EXPECT_EQ(channel_of(found->plane.view, 0), stiff);
    EXPECT_EQ(channel_of(found->plane.view, 2), slide);
    expect_range(scene.haptic.stiffness, 1, 9);  // of the scene's 0.1 to 10 N/mm
    expect_range(scene.haptic.static_friction, 0.1, 0.1);
    expect_range(scene.haptic.dynamic_friction, 0, 0.7);
    EXPECT_TRUE(has_remark(
        scene, "guessed: stiffness of a.x3d is relative to a device's largest: 1 is taken for 10 N/mm"));
    EXPECT_TRUE(has_note(found->notes, "static friction is 0.1 everywhere"));
    EXPECT_TRUE(has_note(found->notes, "beyond static friction"));
    EXPECT_EQ(found->files, (std::vector{folder / "a.x3d", folder / "stiff.png", folder / "s.png"}));
}

TEST_F(StillMaps, ReadX3dUnitsAndNames) {
    const auto codes = write_picture(folder / "i.png", {4, 3});
    const std::string text =
        surface("useRelativeValues='false' minStiffness='200' maxStiffness='1500' staticFriction='0.6'",
                "<ImageTexture USE='I' containerField='stiffnessMap'/>"
                "<ImageTexture USE='I' containerField='dampingMap'/>"
                "<ImageTexture USE='I' containerField='staticFrictionMap'/>");
    // An entity of its own, in a document type that is passed over.
    const std::string whole = "<!DOCTYPE X3D [<!ENTITY a 'b'>]><Group><ImageTexture DEF='I' url='i.png'/>" +
                              text.substr(text.find("<X3D")) + text.substr(text.find("<X3D")) + "</Group>";
    const auto found = must(read("a.x3d", whole));
    EXPECT_EQ(channel_of(found.plane.view, 0), codes);
    EXPECT_EQ(channel_of(found.plane.view, 1), codes);
    expect_range(scene.haptic.stiffness, 0.2, 1.5);
    expect_range(scene.haptic.static_friction, 0, 1);
    expect_range(scene.haptic.dynamic_friction, 0.4, 0.4);
    EXPECT_TRUE(has_note(found.notes, "2 HapticTexturesSurface nodes with maps"));
    EXPECT_TRUE(has_note(found.notes, "dampingMap"));
    EXPECT_TRUE(scene.remarks.empty());
}

TEST_F(StillMaps, TakeFirstExistingFile) {
    std::filesystem::create_directories(folder / "in/textures");
    const auto above = write_picture(folder / "my map.png", {4, 3});
    const std::string urls = "\"http://a.example/stiff.png\" \"gone.png\", \"../my%20map.png\"";
    write_bytes(folder / "in/a.x3d", surface("", map("stiffness", urls)));
    scene = small_scene(4, 3);
    const auto found = must(read_haptic_map(folder / "in/a.x3d", scene));
    EXPECT_EQ(channel_of(found.plane.view, 0), above);
    const auto absolute =
        read("b.x3d", surface("", map("stiffness", "file://" + (folder / "my map.png").string())));
    ASSERT_EQ(message(absolute), "");
    EXPECT_EQ(channel_of(absolute->plane.view, 0), above);
    const auto inside =
        read("c.x3d", surface("", map("staticFriction", "data:image/png;base64," + grey_png)));
    ASSERT_EQ(message(inside), "");
    EXPECT_EQ(channel_of(inside->plane.view, 1), std::vector(grey_png_codes.begin(), grey_png_codes.end()));
    expect_range(scene.haptic.stiffness, 5, 5);
    EXPECT_EQ(inside->files, std::vector{folder / "c.x3d"});
}

TEST_F(StillMaps, JoinDifferentSizesAndKinds) {
    const auto stiff = write_picture(folder / "a.png", {4, 2}),
               wide = write_picture(folder / "b.png", {8, 4, 1, 2});
    const auto colour = write_picture(folder / "c.png", {4, 2, 3});
    const auto found =
        must(read("a.x3d", surface("", map("stiffness", "a.png") + map("staticFriction", "b.png") +
                                           map("dynamicFriction", "c.png"))));
    EXPECT_EQ(channel_of(found.plane.view, 0), stiff);
    const auto held = channel_of(found.plane.view, 1), sliding = channel_of(found.plane.view, 2);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 4; ++x) {
            const auto at = static_cast<std::size_t>(4 * y + x);
            // The pixel below and to the right of where the middle lies.
            EXPECT_NEAR(held[at], wide[static_cast<std::size_t>(8 * (2 * y + 1) + 2 * x + 1)] / 257.0, 0.5);
            EXPECT_EQ(sliding[at], colour[3 * at]);
        }
    for (const char* words :
         {"static friction is 8x4: resampled", "has 16 bits: 8 are kept", "its red is taken"})
        EXPECT_TRUE(has_note(found.notes, words)) << words;
}

TEST_F(StillMaps, ReadGltfMaterial) {
    const auto first = write_picture(folder / "a.png", {4, 3}, 1),
               second = write_picture(folder / "b map.png", {4, 3}, 2);
    const std::string range = R"(, "extras": {"touchable_range": [0.3, 4]})";
    const auto found =
        read("a.gltf", material("\"stiffness\": [" + entry(1, "Reference") + "," +
                                    entry(0, "Low_Resolution") + "," + entry(0, "High_Resolution", range) +
                                    "], \"friction\": [" + entry(1) + "], \"temperature\": []",
                                two_textures));
    ASSERT_EQ(message(found), "");
    EXPECT_EQ(channel_of(found->plane.view, 0), first);
    EXPECT_EQ(channel_of(found->plane.view, 1), second);
    EXPECT_EQ(channel_of(found->plane.view, 2), second);
    expect_range(scene.haptic.stiffness, 0.3, 4);
    expect_range(scene.haptic.static_friction, 0.1, 1);
    EXPECT_TRUE(has_remark(scene, "guessed: a.gltf states no units"));
    for (const char* words : {"3 textures", "static and dynamic friction alike", "temperature"})
        EXPECT_TRUE(has_note(found->notes, words)) << words;
    const auto friction = must(read("b.gltf", material("\"friction\": [" + entry(0) + "]", two_textures)));
    expect_range(scene.haptic.stiffness, 0.6, 0.6);
}

std::string little_endian(std::size_t number) {
    std::string bytes;
    for (int k = 0; k < 4; ++k) bytes += static_cast<char>(number >> (8 * k) & 255);
    return bytes;
}
std::string glb(std::string json, std::string carried) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    carried.resize((carried.size() + 3) / 4 * 4, '\0');
    const std::string chunks = little_endian(json.size()) + "JSON" + json + little_endian(carried.size()) +
                               std::string("BIN\0", 4) + carried;
    return "glTF" + little_endian(2) + little_endian(12 + chunks.size()) + chunks;
}
std::string carried_picture(std::size_t bytes) {
    return R"("textures": [{"source": 0}], "images": [{"bufferView": 0, "mimeType": "image/png"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 3, "byteLength": )" +
           std::to_string(bytes) + "}], ";
}

TEST_F(StillMaps, ReadPicturesInGltfBytes) {
    const auto codes = write_picture(folder / "a.png", {4, 3});
    const std::string png = read_bytes(folder / "a.png");
    const std::string stiffness = "\"stiffness\": [" + entry(0) + "]";
    const std::string json =
        material(stiffness, carried_picture(png.size()) + "\"buffers\": [{\"byteLength\": 3}]");
    const auto binary = must(read("a.glb", glb(json, "xyz" + png)));
    EXPECT_EQ(channel_of(binary.plane.view, 0), codes);
    write_bytes(folder / "a.bin", "xyz" + png);
    const auto beside = must(read(
        "b.gltf", material(stiffness, carried_picture(png.size()) + "\"buffers\": [{\"uri\": \"a.bin\"}]")));
    EXPECT_EQ(channel_of(beside.plane.view, 0), codes);
    EXPECT_EQ(beside.files, (std::vector{folder / "b.gltf", folder / "a.bin"}));
    const auto text =
        read("c.gltf",
             material(stiffness,
                      "\"textures\": [{\"source\": 0}], \"images\": [{\"uri\": \"data:image/png;base64," +
                          grey_png + "\"}]"));
    ASSERT_EQ(message(text), "");
    EXPECT_EQ(channel_of(text->plane.view, 0), std::vector(grey_png_codes.begin(), grey_png_codes.end()));
    expect_refused(
        "a.glb", glb(material(stiffness, carried_picture(png.size() + 4) + "\"buffers\": [{}]"), "xyz" + png),
        "within its buffer");
}

TEST_F(StillMaps, RefuseInvalidInOneLine) {
    write_picture(folder / "a.png", {4, 3});
    const auto x3d = [&](const std::string& fields, const std::string& maps, const std::string& words) {
        expect_refused("a.x3d", surface(fields, maps), words);
    };
    const std::string stiff = map("stiffness", "a.png");
    x3d("", "", "its HapticTexturesSurface has no map");
    x3d("", map("damping", "a.png"), "has no map");
    x3d("maxStiffness='much'", stiff, "maxStiffness is \"much\": must be a number");
    x3d("minStiffness='0.5' maxStiffness='0.2'", stiff, "at least minStiffness");
    x3d("useRelativeValues='perhaps'", stiff, "true or false");
    x3d("", map("stiffness", "http://a.example/a.png"), "must be a picture in a file");
    x3d("", map("stiffness", "gone.png"), "gone.png: does not exist");
    x3d("", map("stiffness", "a&#10;b.png"), "control characters");
    x3d("", map("stiffness", "data:image/png;base64,@@@@"), "base64");
    x3d("", map("stiffness", "data:image/png;base64,AAAAA"), "base64");
    x3d("", "<PixelTexture containerField='stiffnessMap'/>", "must be an ImageTexture");
    x3d("", "<ImageTexture USE='J' containerField='stiffnessMap'/>", "the DEF of a node");
    expect_refused("b.x3d", "<X3D><Scene/></X3D>", "has no HapticTexturesSurface");
    expect_refused("b.x3d", "<X3D>\n<Scene>", "line 2: must be X3D in XML");
    expect_refused("b.x3dv", "#X3D V3.3 utf8\n", "classic encoding");
    expect_refused("b.x3d", "<X3D>" + std::string(17 << 20, ' ') + "</X3D>", "16 MiB");
    expect_refused("b.txt", "stiffness", "is no haptic map");
    const std::string stiffness = "\"stiffness\": [" + entry(0) + "]";
    const auto gltf = [&](const std::string& properties, const std::string& more, const std::string& words) {
        expect_refused("a.gltf", material(properties, more), words);
    };
    gltf("\"name\": \"x\"", two_textures, "has no material");
    gltf("\"stiffness\": [" + entry(0, "Reference") + "]", two_textures, "High_Resolution or Low");
    gltf("\"stiffness\": [" + entry(7) + "]", two_textures, "a number of one of 2 textures");
    gltf(stiffness, "\"textures\": [{}]", "has no source");
    gltf(stiffness, "\"textures\": [{\"source\": 0}], \"images\": [{\"uri\": \"ftp:a.png\"}]",
         "must be a file here");
    gltf(stiffness, "\"textures\": 3", "must be an array");
    gltf("\"stiffness\": [" + entry(0, "High_Resolution", ", \"extras\": {\"touchable_range\": [1]}") + "]",
         two_textures, "must be [black, white]");
    expect_refused("a.gltf", "{\"asset\": {}}", "has no material");
    expect_refused("a.glb", "glTF" + little_endian(1) + little_endian(12), "GLB of version 2");
}

/// A clip of three frames with a haptic picture, 6x4.
Result<std::unique_ptr<ClipReader>> small_clip(const TemporaryFolder& folder, bool has_haptic) {
    if (auto written = write_clip(folder / "clip.mkv", small_scene(6, 4), 3, {false, has_haptic, false});
        !written)
        return written.error();
    return open_clip(folder / "clip.mkv");
}

TEST_F(StillMaps, ServeEveryFrame) {
    for (const bool has_haptic : {false, true}) {
        const auto rgb = write_picture(folder / "m.png", {3, 2, 3}),
                   bumps = write_picture(folder / "h.png", {6, 4});
        auto clip = with_still_maps(small_clip(folder, has_haptic), {folder / "m.png", folder / "h.png"});
        ASSERT_EQ(message(clip), "");
        const auto notes = clip_notes(**clip);
        EXPECT_EQ(has_note(notes, "m.png is haptic of every frame, in place of the clip's own"), has_haptic);
        EXPECT_TRUE(has_note(notes, "haptic is 3x2: resampled"));
        EXPECT_FALSE(has_note(notes, "no haptic plane"));
        EXPECT_TRUE(has_note(notes, "height_map.max in a scene file says otherwise"));
        std::string roles;
        for (const TrackInfo& track : (*clip)->tracks()) roles += track.role + " ";
        EXPECT_EQ(roles, "depth haptic height ");
        for (const char* input : {"clip.mkv", "m.png", "h.png"})
            EXPECT_EQ(std::count((*clip)->inputs().begin(), (*clip)->inputs().end(), folder / input), 1)
                << input;
        const auto frames = must(read_all(**clip));
        ASSERT_EQ(frames.size(), 3U);
        for (const RawFrame& frame : frames) {
            EXPECT_EQ(frame.haptic.data, frames.front().haptic.data) << "one in memory serves all";
            EXPECT_EQ(channel_of(frame.height, 0), bumps);
            for (int y = 0; y < 4; ++y)
                for (int x = 0; x < 6; ++x)
                    ASSERT_EQ(frame.haptic.sample(x, y, 1),
                              rgb[static_cast<std::size_t>(3 * (y / 2 * 3 + x / 2) + 1)]);
        }
    }
}

TEST_F(StillMaps, TakeGreyAsStiffness) {
    const auto codes = write_picture(folder / "m.png", {6, 4});
    auto clip = must(with_still_maps(small_clip(folder, true), {folder / "m.png", {}}));
    EXPECT_EQ(channel_of(read_all(*clip)->at(1).haptic, 0), codes);
    expect_range(clip->scene().haptic.static_friction, 0.4, 0.4);
    EXPECT_TRUE(has_note(clip->notes(), "haptic is grey"));
    write_bytes(folder / "m.jpg", "\xff\xd8\xff");
    EXPECT_FALSE(with_still_maps(small_clip(folder, true), {folder / "m.jpg", {}}));
    EXPECT_FALSE(with_still_maps(small_clip(folder, true), {{}, folder / "gone.png"}));
}

TEST_F(StillMaps, ScaleHeights) {
    write_picture(folder / "h.png", {6, 4, 1, 2});
    scene = small_scene(6, 4);
    ASSERT_EQ(message(read_height_map(folder / "h.png", scene)), "");
    EXPECT_EQ(scene.height_coding.code_max, 65535);
    EXPECT_EQ(scene.height_coding.units, HeightUnits::levels);
    EXPECT_DOUBLE_EQ(scene.height_coding.max_height, 1);
    scene.height_coding.max_height = 7;
    const auto stated = read_height_map(folder / "h.png", scene);
    EXPECT_TRUE(has_note(stated->notes, "as height_map says"));
    EXPECT_DOUBLE_EQ(scene.height_coding.max_height, 7);
    // Millimetres up to 2.55 m: a level is 10 mm, and there is room for it.
    Scene metric = small_scene(6, 4, 16);
    metric.depth.kind = DepthCodingKind::metric;
    metric.depth.scale = 1;
    metric.depth.near = 0;
    metric.depth.far = 2550;
    derive_valid_range(metric.depth);
    const auto found = must(read_height_map(folder / "h.png", metric));
    EXPECT_EQ(metric.height_coding.units, HeightUnits::world);
    EXPECT_DOUBLE_EQ(metric.height_coding.max_height, 10);
    EXPECT_TRUE(has_remark(metric, "depths below 20 mm are taken for none"));
    EXPECT_EQ(message(validate(metric)), "");
}

TEST_F(StillMaps, AreNamedBySceneFiles) {
    write_picture(folder / "m.png", {6, 4});
    write_picture(folder / "h.png", {6, 4}, 2);
    write_picture(folder / "d1.png", {6, 4}, 3);
    write_picture(folder / "d2.png", {6, 4}, 4);
    write_bytes(folder / "m.x3d", surface("maxStiffness='0.5'", map("stiffness", "m.png")));
    Scene named = small_scene(6, 4);
    named.folder = FolderSource{"d%d.png", "", "m.x3d", "", 1, 0};
    write_bytes(folder / "folder.json", scene_to_json(named));
    auto clip = must(open_clip(folder / "folder.json"));
    EXPECT_EQ(clip->tracks().back().codec, "x3d");
    expect_range(clip->scene().haptic.stiffness, 0, 5);
    named.folder.reset();
    named.video = VideoSource{.depth = "d.mkv", .colour = "", .haptic = "m.x3d", .height = "h.png"};
    ASSERT_EQ(message(write_clip(folder / "d.mkv", small_scene(6, 4), 2, {false, false, false})), "");
    write_bytes(folder / "video.json", scene_to_json(named));
    auto video = must(open_clip(folder / "video.json"));
    expect_range(video->scene().haptic.stiffness, 0, 5);
    EXPECT_TRUE(same_plane(read_all(*video)->at(1).haptic, read_all(*clip)->at(1).haptic));
    EXPECT_EQ(video->tracks().size(), 3U);
    EXPECT_EQ(parse_scene(scene_to_json(named), "again")->scene.video->height, "h.png");
}

TEST_F(StillMaps, SurviveBombs) {
    const LimitedMemory limit(512);
    std::string entities = "<!DOCTYPE X3D [<!ENTITY a0 'aaaaaaaaaa'>";
    for (int k = 1; k < 30; ++k) {
        const std::string before = "&a" + std::to_string(k - 1) + ";";
        entities += "<!ENTITY a" + std::to_string(k) + " '" + before + before + before + before + "'>";
    }
    const std::string text = surface("", map("stiffness", "&a29;"));
    expect_refused("a.x3d", entities + "]>" + text.substr(text.find("<X3D")), "a29");
    std::string deep;
    for (int k = 0; k < 300'000; ++k) deep += "<Group>";
    expect_refused("a.x3d", deep, "must be X3D in XML");
    for (int k = 0; k < 300'000; ++k) deep += "</Group>";
    expect_refused("a.x3d", deep, "has no HapticTexturesSurface");
    std::string many;
    while (many.size() < (15U << 20U) / sweep_step()) many += "<a/>x";
    expect_refused("a.x3d", "<X3D>" + many + "</X3D>", "has no HapticTexturesSurface");
    expect_refused("a.gltf", "{\"a\": " + std::string(100'000, '['), "nested too deeply");
    std::string list = "{\"a\": [";
    while (list.size() < (7U << 20U) / sweep_step()) list += "{},";
    expect_refused("a.gltf", list + "{}]}", "has no material");
    // 16384 x 16384 in a few bytes.
    write_picture(folder / "a.png", {4, 3});
    std::string png = read_bytes(folder / "a.png");
    png.replace(16, 8, std::string("\0\0\x40\0\0\0\x40\0", 8));
    write_bytes(folder / "a.png", png);
    expect_refused("b.x3d", surface("", map("stiffness", "a.png")), "a.png");
}

// A static MPEG-4 scene in one MP4 file: its textures are pictures, each a track with one sample.

constexpr int still_wide = 24, still_high = 16;
constexpr std::uint16_t first_object = 20;  // of depth; those of other planes follow

/// How MP4Box describes a track of PNG pictures of this size: its DecoderSpecificInfo is empty (0500), for
/// which FFmpeg refuses the whole file.
constexpr std::string_view description_by_mp4box =
    "00000000000000010000007b6d703476000000000000000100000000000000000000000000000000001800100048000000480000"
    "00000000000100000000000000000000000000000000000000000000000000000000000000000018ffff00000025657364730000"
    "00000317000000040f6d110110c500088628000886280500060102";

mpeg4::Bytes bytes_of_hex(std::string_view text) {
    mpeg4::Bytes bytes;
    for (std::size_t k = 0; k + 1 < text.size(); k += 2)
        bytes.push_back(static_cast<std::uint8_t>(std::stoi(std::string(text.substr(k, 2)), nullptr, 16)));
    return bytes;
}

/// A file of one sample in each track, in the order of the planes from the last to the first, as FFmpeg
/// writes it.
std::string tracks_of(const std::filesystem::path& file, const std::map<PlaneRole, std::string>& pictures,
                      int samples) {
    AVFormatContext* muxer = nullptr;
    EXPECT_GE(avformat_alloc_output_context2(&muxer, nullptr, "mp4", file.c_str()), 0);
    EXPECT_GE(avio_open(&muxer->pb, file.c_str(), AVIO_FLAG_WRITE), 0);
    for (auto picture = pictures.rbegin(); picture != pictures.rend(); ++picture) {
        AVStream* const stream = avformat_new_stream(muxer, nullptr);
        stream->codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
        stream->codecpar->codec_id = picture->second[0] == '\xff' ? AV_CODEC_ID_MJPEG : AV_CODEC_ID_PNG;
        stream->codecpar->width = still_wide;
        stream->codecpar->height = still_high;
        stream->time_base = {1, 1000};
    }
    EXPECT_GE(avformat_write_header(muxer, nullptr), 0);
    for (int n = 0; n < samples; ++n) {
        int stream = 0;
        for (auto picture = pictures.rbegin(); picture != pictures.rend(); ++picture, ++stream) {
            const PacketPtr packet(av_packet_alloc());
            EXPECT_GE(av_new_packet(packet.get(), static_cast<int>(picture->second.size())), 0);
            std::memcpy(packet->data, picture->second.data(), picture->second.size());
            packet->stream_index = stream;
            packet->pts = packet->dts = av_rescale_q(n, {1, 1}, muxer->streams[stream]->time_base);
            packet->duration = av_rescale_q(1, {1, 1}, muxer->streams[stream]->time_base);
            packet->flags |= AV_PKT_FLAG_KEY;
            EXPECT_GE(av_write_frame(muxer, packet.get()), 0);
        }
    }
    EXPECT_GE(av_write_trailer(muxer), 0);
    avio_closep(&muxer->pb);
    avformat_free_context(muxer);
    return read_bytes(file);
}

class Mp4StillClips : public ::testing::Test {
protected:
    void SetUp() override {
        scene.camera = camera_from_focal_length(50, 1, still_wide, still_high);
        scene.height_coding = {1.5, HeightUnits::levels, 255};
        frame = test_frame(scene, 0, all_planes);
        put(PlaneRole::depth, frame.depth);
        put(PlaneRole::colour, frame.colour);
        put(PlaneRole::haptic, frame.haptic);
        put(PlaneRole::height, frame.height);
    }
    void put(PlaneRole role, const PlaneView& plane) {
        ASSERT_EQ(
            message(write_png_to(folder / "x.png", plane, "x.png", PngEffort::quick, png_colours(role))), "");
        pictures[role] = read_bytes(folder / "x.png");
    }
    /// Nodes as `nodes_of_pictures` has them, their textures objects of the file.
    mpeg4::ClipNodes nodes() const {
        SceneDescription described(scene);
        described.unstated.filters = all_unstated;
        described.scene.folder = FolderSource{.depth = "d", .colour = "c", .haptic = "s", .height = "h"};
        mpeg4::ClipNodes made = mpeg4::nodes_of_pictures(described);
        const auto object = [](PlaneRole role) {
            return mpeg4::ClipNodes::Texture{
                {.object = static_cast<std::uint16_t>(first_object + static_cast<int>(role))}, false};
        };
        made.depth = object(PlaneRole::depth);
        made.colour = object(PlaneRole::colour);
        made.haptic = object(PlaneRole::haptic);
        made.height = object(PlaneRole::height);
        return made;
    }
    std::filesystem::path written(const mpeg4::ClipNodes& nodes, int samples = 1, bool by_mp4box = false) {
        return written(mpeg4::scene_of(nodes, still_wide, still_high), samples, by_mp4box);
    }
    std::filesystem::path written(const mpeg4::SceneTree& tree, int samples, bool by_mp4box) {
        std::string bytes = tracks_of(folder / "tracks.mp4", pictures, samples);
        std::size_t moov = 0;
        for (std::size_t at = 0; at + 8 <= bytes.size();) {
            const std::string size = bytes.substr(at, 4);
            if (bytes.compare(at + 4, 4, "moov") == 0) moov = at;
            std::size_t step = 0;
            for (const char c : size) step = step << 8 | static_cast<unsigned char>(c);
            at += std::max<std::size_t>(step, 8);
        }
        mpeg4::SceneStream stream;
        std::uint32_t track = static_cast<std::uint32_t>(pictures.size());
        for (const auto& [role, picture] : pictures)
            stream.objects[static_cast<std::uint16_t>(first_object + static_cast<int>(role))] = track--;
        stream.config = mpeg4::config_for(tree, still_wide, still_high);
        const auto encoded = mpeg4::encode_scene(tree, stream.config);
        EXPECT_EQ(message(encoded), "");
        stream.scene = *encoded;
        mpeg4::Bytes movie(bytes.begin() + static_cast<std::ptrdiff_t>(moov) + 8, bytes.end());
        constexpr std::string_view description[] = {"trak", "mdia", "minf", "stbl", "stsd"};
        if (by_mp4box) movie = mpeg4::with_content(movie, description, bytes_of_hex(description_by_mp4box));
        const auto made = mpeg4::with_scene_stream(movie, stream, 1, moov);
        EXPECT_EQ(message(made), "");
        write_bytes(folder / "stills.mp4", bytes.substr(0, moov) + std::string(made->begin(), made->end()));
        return folder / "stills.mp4";
    }
    TemporaryFolder folder;
    Scene scene = small_scene(still_wide, still_high, 16);
    RawFrame frame;
    std::map<PlaneRole, std::string> pictures;
};

/// Sixteen bits are in one picture; twelve need more than nodes say.
TEST_F(Mp4StillClips, KeepEveryPlane) {
    for (const int bits : {8, 12, 16}) {
        scene.depth_bits = bits;
        scene.depth.code_max = static_cast<std::uint16_t>((1 << bits) - 1);
        derive_valid_range(scene.depth);
        SetUp();
        EXPECT_EQ(nodes().scene_file.empty(), bits != 12);
        const auto clip = must(open_clip(written(nodes())));
        EXPECT_EQ(clip->frame_count(), 1);
        Scene read = clip->scene();
        read.name = scene.name;
        EXPECT_EQ(scene_to_json(read), scene_to_json(scene)) << bits;
        EXPECT_EQ(clip->tracks().front().codec, "png");
        const auto frames = must(read_all(*clip));
        ASSERT_EQ(frames.size(), 1U);
        EXPECT_TRUE(same_frame(frames.front(), frame)) << bits;
    }
    scene.name = "another";
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const auto told = must(open_clip(folder / "stills.mp4", folder / "scene.json"));
    EXPECT_EQ(told->scene().name, "another");
    const auto guessed = must(guess_clip(folder / "stills.mp4", {}));
    EXPECT_EQ(guessed.scene.depth.far, 200);
}

TEST_F(Mp4StillClips, ReadMp4BoxTracks) {
    const auto frames = must(read_clip(written(nodes(), 1, true)));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_TRUE(same_frame(frames.front(), frame));
}

/// The scene says what is wrong, not FFmpeg.
TEST_F(Mp4StillClips, NameMp4BoxSceneFault) {
    mpeg4::SceneTree tree = mpeg4::scene_of(nodes(), still_wide, still_high);
    tree.prototypes.back().fields[1].name = "pixelBreadth";
    const auto& shape = std::get<mpeg4::NodePtr>(tree.root->fields[0].values[0]);
    std::get<mpeg4::NodePtr>(shape->fields.back().values[0])->fields[1].name = "pixelBreadth";
    const std::string refused = message(open_clip(written(tree, 1, true)));
    EXPECT_TRUE(
        has_words(refused, "its MPEG-4 scene is no touchable clip: Depth: must have a field pixelWidth"));
}

TEST_F(Mp4StillClips, NoteJpegAndLaterPictures) {
    pictures[PlaneRole::colour] = pictures[PlaneRole::haptic] =
        jpeg_of(still_wide, still_high, [](int, int, int plane) { return plane > 0 ? 128 : 77; });
    const auto clip = must(open_clip(written(nodes(), 2)));
    EXPECT_TRUE(is_noted(*clip, "haptic is stored as mjpeg, which changes values"));
    EXPECT_FALSE(is_noted(*clip, "colour is stored as"));
    EXPECT_TRUE(is_noted(*clip, "track depth has 2 pictures; its ImageTexture is the first"));
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames.front().colour.sample(3, 2, 1), 77);
    EXPECT_TRUE(same_plane(frames.front().depth, frame.depth));
}

TEST_F(Mp4StillClips, NameFaults) {
    const auto refusal = [&](const mpeg4::ClipNodes& changed) {
        return message(open_clip(written(changed)));
    };
    mpeg4::ClipNodes changed = nodes();
    changed.colour->is_movie = true;
    EXPECT_TRUE(has_words(refusal(changed),
                          "stills.mp4: its MPEG-4 scene has depth in an ImageTexture and colour in a "
                          "MovieTexture: must all be one or the other"));
    changed = nodes();
    changed.height->url.object = 77;
    EXPECT_TRUE(
        has_words(refusal(changed), "stills.mp4: its MPEG-4 scene: height is object 77, which is no track"));
    changed = nodes();
    changed.far = 5;
    EXPECT_TRUE(has_words(refusal(changed), "stills.mp4: its MPEG-4 scene: depth.near"));
    for (const PlaneRole role : all_roles) {
        const std::string whole = pictures[role];
        for (const std::size_t length : {whole.size() - 20, std::size_t{40}}) {
            pictures[role].resize(length);
            EXPECT_TRUE(has_words(refusal(nodes()),
                                  "stills.mp4: track " + std::string(role_name(role)) + ": is cut short"));
        }
        pictures[role] = whole;
    }
    const Samples grey(2 * 7 * 5);
    put(PlaneRole::haptic, PlaneView{grey.data(), 14, 7, 5, 2, 1});
    EXPECT_NE(refusal(nodes()), "") << "stiffness of 16 bits is none";
    put(PlaneRole::haptic, PlaneView{grey.data(), 7, 7, 5, 1, 1});
    const auto clip = must(open_clip(written(nodes())));
    EXPECT_TRUE(is_noted(*clip, "haptic is 7x5: resampled"));
}

/// Cut anywhere it is refused in one line, but for the zero behind the scene's samples and for tags.
TEST_F(Mp4StillClips, RefuseCutFiles) {
    const std::string whole = read_bytes(written(nodes()));
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 150) {
        write_bytes(folder / "cut.mp4", whole.substr(0, length));
        const auto clip = open_clip(folder / "cut.mp4");
        ASSERT_FALSE(clip) << length;
        EXPECT_EQ(message(clip).find('\n'), std::string::npos);
    }
}

}  // namespace
}  // namespace touchable::test
