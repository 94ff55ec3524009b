// Renderings as clips: a file, or a numbered folder of files, with depth, colour and material indices in them
// (tests/picture/blender/render_seeds.py made the files).
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>

#include <algorithm>

#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/kept_clips.hpp"
#include "tests/opened_files.hpp"

namespace touchable::test {
namespace {

class Rendering : public ::testing::Test {
protected:
    /// `count` files r_0001.exr and on, all alike.
    void render(int count, const std::string& seed = "layers_half.exr") const {
        const std::string bytes =
            read_bytes(std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds/exr_layers" / seed);
        for (int n = 1; n <= count; ++n) write_bytes(folder / ("r_000" + std::to_string(n) + ".exr"), bytes);
    }
    /// Metres, of these files, with what stands in `haptic` and the planes that `planes` names.
    std::string scene_of(const std::string& haptic, const std::string& planes,
                         const std::string& pattern = "r_%04d.exr") const {
        return R"({"touchable_scene": 1, "width": 16, "height": 12, "metres_per_unit": 1,
                   "camera": {"fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5},
                   "depth": {"coding": "metric", "scale": 1, "near": 5, "far": 20}, "haptic": )" +
               haptic + R"(, "folder": {"first": 1, "depth": ")" + pattern + '"' + planes + "}}";
    }
    Result<std::unique_ptr<ClipReader>> open_described(const std::string& scene) const {
        write_bytes(folder / "scene.json", scene);
        return open_clip(folder.path());
    }
    /// Left, right and the box: docs beside the script.
    static void expect_seen(const RawFrame& frame, const Scene& scene) {
        const auto depth = [&](int x, int y) { return scene.depth.depth(frame.depth.sample(x, y)); };
        EXPECT_NEAR(depth(4, 9), 10, 1e-3);
        EXPECT_NEAR(depth(12, 4), 10, 1e-3);
        EXPECT_NEAR(depth(4, 3), 8, 1e-3);
        EXPECT_FALSE(scene.depth.is_valid(frame.depth.sample(0, 0)));
        ASSERT_FALSE(frame.colour.empty());
        const auto is = [&](int x, int y, std::array<int, 3> rgb) {
            const std::uint8_t* at = frame.colour.row(y) + 3 * x;
            return at[0] == rgb[0] && at[1] == rgb[1] && at[2] == rgb[2];
        };
        EXPECT_TRUE(is(4, 9, {188, 137, 99}));
        EXPECT_TRUE(is(12, 4, {0, 0, 255}));
        EXPECT_TRUE(is(4, 3, {255, 71, 0}));
    }
    TemporaryFolder folder;
};

TEST_F(Rendering, OfOneFileOpensWithDepthAndColour) {
    for (const char* seed : {"layers_half.exr", "layers_float.exr", "two_layers.exr", "z_half.exr"}) {
        SCOPED_TRACE(seed);
        render(1, seed);
        auto reader = open_clip(folder / "r_0001.exr");
        ASSERT_EQ(message(reader), "");
        const auto frames = read_all(**reader);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 1U);
        expect_seen(frames->at(0), (*reader)->scene());
        EXPECT_TRUE(is_noted(**reader, "linear light shown as sRGB"));
        EXPECT_TRUE(is_noted(**reader, "values are metres"));
        EXPECT_EQ(is_noted(**reader, "nothing says what they feel like"), std::string(seed) != "z_half.exr");
    }
    auto reader = open_clip(folder / "r_0001.exr");
    EXPECT_TRUE(is_noted(**reader, "depth is channel Z, colour is R, G, B beside it"));
    render(1, "two_layers.exr");
    reader = open_clip(folder / "r_0001.exr");
    EXPECT_TRUE(is_noted(**reader, "depth is channel b.Depth.Z, colour is b.Combined beside it"));
    EXPECT_TRUE(is_noted(**reader, "the files have material indices (b.IndexMA.X: 0, 2, 5)"));
}

TEST_F(Rendering, OfAFolderOfFilesIsReadFromEachOnce) {
    render(9);
    for (const bool is_described : {false, true}) {
        if (is_described) write_bytes(folder / "scene.json", scene_of("{}", R"(, "colour": "r_%04d.exr")"));
        OpenedFiles opened(folder.path());
        auto reader = open_clip(folder.path());
        ASSERT_EQ(message(reader), "");
        const auto frames = read_all(**reader);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 9U);
        for (const RawFrame& frame : *frames) expect_seen(frame, (*reader)->scene());
        // The first is read once more, for its colour: the range of depth is searched in between.
        for (const auto& [name, count] : opened.counts())
            EXPECT_LE(count, name.find("0001") != std::string::npos ? 2 : 1) << name;
        EXPECT_EQ((*reader)->inputs().size(), is_described ? 10U : 9U);
    }
}

TEST_F(Rendering, MaterialIndicesHaveThePropertiesOfATable) {
    render(2);
    const std::string planes = R"(, "colour": "r_%04d.exr", "haptic": "r_%04d.exr")";
    auto reader = open_described(scene_of(R"({"materials": {"2": {"stiffness": 2, "static_friction": 0.9},
                                                           "5": {"stiffness": 0.3, "dynamic_friction": 0.1}}})",
                                          planes));
    ASSERT_EQ(message(reader), "");
    EXPECT_TRUE(is_noted(**reader, "haptic is that of 2 materials"));
    const Scene& scene = (*reader)->scene();
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    for (const RawFrame& frame : *frames) {
        expect_seen(frame, scene);
        ASSERT_FALSE(frame.haptic.empty());
        const auto at = [&](int x, int y) {
            const std::uint8_t* rgb = frame.haptic.row(y) + 3 * x;
            return scene.haptic.at(rgb[0], rgb[1], rgb[2]);
        };
        const auto expect = [&](int x, int y, const HapticProperties& wanted) {
            EXPECT_NEAR(at(x, y).stiffness, wanted.stiffness, 1e-9 + 0.5 * 1700 / 255);
            EXPECT_NEAR(at(x, y).static_friction, wanted.static_friction, 1e-9 + 0.5 * 0.5 / 255);
            EXPECT_NEAR(at(x, y).dynamic_friction, wanted.dynamic_friction, 1e-9 + 0.5 * 0.2 / 255);
        };
        expect(4, 9, {600, 0.4, 0.3});  // the default ones: 0 is not in the table
        expect(12, 4, {2000, 0.9, 0.3});
        expect(4, 3, {300, 0.4, 0.1});
        EXPECT_EQ(at(12, 4).stiffness, 2000);  // ends of a range are exact
        EXPECT_EQ(at(4, 3).stiffness, 300);
    }
    // The file itself, as the same scene describes it.
    reader = open_clip(folder / "r_0002.exr", folder / "scene.json");
    ASSERT_EQ(message(reader), "");
    const auto one = read_all(**reader);
    ASSERT_EQ(message(one), "");
    expect_seen(one->at(0), (*reader)->scene());
    EXPECT_TRUE(same_plane(one->at(0).haptic, frames->at(0).haptic));
}

TEST_F(Rendering, MayHaveItsPlanesInFilesOfTheirOwn) {
    render(1);
    write_bytes(folder / "c.exr", read_bytes(folder / "r_0001.exr"));
    write_bytes(folder / "m.exr", read_bytes(folder / "r_0001.exr"));
    auto reader = open_described(
        scene_of(R"({"materials": {"5": {"stiffness": 2}}})", R"(, "colour": "c.exr", "haptic": "m.exr")"));
    ASSERT_EQ(message(reader), "");
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    expect_seen(frames->at(0), (*reader)->scene());
    EXPECT_EQ(frames->at(0).haptic.row(3)[3 * 4], 255);
    EXPECT_EQ(frames->at(0).haptic.row(4)[3 * 12], 0);
}

TEST_F(Rendering, WhatIsMissingIsNamed) {
    render(1);
    const std::string file = (folder / "r_0001.exr").string();
    EXPECT_EQ(message(open_described(scene_of("{}", R"(, "haptic": "r_%04d.exr")"))),
              file +
                  " (haptic, frame 0): is of material indices: the scene file's haptic.materials must say "
                  "what they feel like");
    render(1, "z_half.exr");
    EXPECT_EQ(message(open_described(scene_of(R"({"materials": {"5": {}}})", R"(, "haptic": "r_%04d.exr")"))),
              file +
                  ": has no material indices: must have a layer IndexMA of each pixel, but has A, B, G, R, Z "
                  "(haptic, frame 0)");
    EXPECT_TRUE(is_refused(open_described(scene_of(R"({"materials": {"5": {}}})", "")), "folder.haptic"));
}

/// A scene without a table is told too; a map of touch that stays takes the place of what was said.
TEST_F(Rendering, IndicesThatNobodyUsesAreToldOnce) {
    render(3);
    auto reader = open_described(scene_of("{}", ""));
    ASSERT_EQ(message(reader), "");
    EXPECT_TRUE(is_noted(
        **reader, "haptic is not there: the files have material indices (ViewLayer.IndexMA.X: 0, 2, 5)"));
    const auto scene = (*reader)->scene();
    for (const Remark& remark : scene.remarks) EXPECT_EQ(remark.what.find("indices"), std::string::npos);
    Image map{1, 1, 1, 3, {255, 128, 128}};
    ASSERT_EQ(message(write_png(folder / "map.png", map.view())), "");
    reader = open_described(scene_of("{}", R"(, "haptic": "map.png")"));
    ASSERT_EQ(message(reader), "");
    EXPECT_FALSE(is_noted(**reader, "material indices"));
    // Whatever the file is called.
    for (const std::string name : {"DEPTH_%04d.EXR", "depth_%04d"}) {
        std::filesystem::copy_file(folder / "r_0001.exr",
                                   folder / std::string(name).replace(name.find('%'), 4, "0001"));
        reader = open_described(scene_of("{}", "", name));
        ASSERT_EQ(message(reader), "");
        EXPECT_TRUE(is_noted(**reader, "the files have material indices (ViewLayer.IndexMA.X: 0, 2, 5)"))
            << name;
    }
}

/// As Unreal's Movie Render Queue writes them: colour, and the pass WorldDepth, in halves.
void write_unreals(const std::filesystem::path& file, float centimetres) {
    Imf::Header header(16, 12);
    std::vector<half> depth(16 * 12, half(centimetres)), light(16 * 12, half(0.5F));
    depth[0] = half(65504.0F);  // the sky
    Imf::FrameBuffer frame;
    for (const std::string layer : {"", "FinalImageMovieRenderQueue_WorldDepth."})
        for (const char* own : {"R", "G", "B", "A"}) {
            header.channels().insert(layer + own, Imf::Channel(Imf::HALF));
            half* const from = layer.empty() || *own == 'A' ? light.data() : depth.data();
            frame.insert(layer + own, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(from), sizeof(half),
                                                 16 * sizeof(half)));
        }
    Imf::OutputFile output(file.c_str(), header);
    output.setFrameBuffer(frame);
    output.writePixels(12);
}

TEST_F(Rendering, UnrealsWorldDepthIsInCentimetres) {
    write_unreals(folder / "Shot.0001.exr", 150);
    for (const char* name : {"shots", "pictures"}) std::filesystem::create_directories(folder / name);
    for (const char* name : {"Shot.0001.exr", "Shot.0002.exr"})
        std::filesystem::copy_file(folder / "Shot.0001.exr", folder / "shots" / name);
    for (const char* name : {"Shot.0001.exr", "shots"}) {
        SCOPED_TRACE(name);
        auto reader = open_clip(folder / name);
        ASSERT_EQ(message(reader), "");
        EXPECT_TRUE(is_noted(**reader, "Unreal's WorldDepth: centimetres"));
        const auto frame = (*reader)->next();
        ASSERT_EQ(message(frame), "");
        ASSERT_TRUE(frame->has_value());
        const Scene& scene = (*reader)->scene();
        EXPECT_NEAR(scene.depth.depth((*frame)->depth.sample(7, 5)) * scene.metres_per_unit, 1.5, 1e-3);
        EXPECT_FALSE(scene.depth.is_valid((*frame)->depth.sample(0, 0)));
        EXPECT_FALSE((*frame)->colour.empty());
    }
    // A channel or a layer by name, for which a scene file may say the rest.
    SourceDescription named;
    for (const char* channel : {"A", "finalimagemovierenderqueue_worlddepth", "G"}) {
        named.channel = channel;
        const auto reader = open_clip(folder / "Shot.0001.exr", {}, named);
        ASSERT_EQ(message(reader), "");
        EXPECT_EQ(bool(is_noted(**reader, "centimetres")), named.channel.size() > 1) << channel;
    }
    named.channel = "Z";
    for (const char* name : {"Shot.0001.exr", "shots"})
        EXPECT_TRUE(is_refused(open_clip(folder / name, {}, named), "has no channel \"Z\", but A, B, "))
            << name;
    Samples memory(2 * 16 * 12, 3);
    ASSERT_EQ(message(write_png(folder / "pictures/depth_1.png", PlaneView{memory.data(), 32, 16, 12, 2, 1})),
              "");
    for (const char* name : {"pictures/depth_1.png", "pictures"})
        EXPECT_TRUE(is_refused(open_clip(folder / name, {}, named), "is no OpenEXR file")) << name;
    SourceDescription known;
    known.metres_per_code = 1;
    const auto metres = open_clip(folder / "Shot.0001.exr", {}, known);
    ASSERT_EQ(message(metres), "");
    EXPECT_FALSE(is_noted(**metres, "centimetres"));
}

}  // namespace
}  // namespace touchable::test
