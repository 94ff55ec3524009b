// glTF scenes that are damaged, or that ask for what is not read, are refused in one line.
#include <functional>

#include "tests/gltf/gltf_fixture.hpp"

namespace touchable::test {
namespace {

using Json = nlohmann::json;

Json& media(Json& gltf) {
    return gltf["extensions"]["MPEG_media"]["media"][0]["alternatives"][0];
}
Json& frames_of(Json& gltf, std::size_t plane) {  // buffer 0 is the mesh's
    return gltf["buffers"][plane + 1]["extensions"]["MPEG_buffer_circular"];
}
Json& material(Json& gltf) {
    return gltf["extensions"]["MPEG_haptic_material"]["materials"][0];
}

struct Fault {
    std::function<void(Json&)> make;
    const char* words;
};

TEST_F(GltfClipTest, NothingIsFetchedAndNothingLiesOutside) {
    write(2);
    const Json whole = gltf;
    for (const char* uri : {"http://example.org/clip.mp4", "ftp://clip.mp4", "//host/clip.mp4"}) {
        media(gltf)["uri"] = uri;
        expect_refused("nothing is fetched");
    }
    for (const char* uri : {"../clip.mp4", "a/../../clip.mp4", "/etc/clip.mp4", "%2e%2e/clip.mp4",
                            "file:///etc/passwd", "data:video/mp4;base64,AAAA"}) {
        media(gltf)["uri"] = uri;
        expect_refused("must be a file beside it or in a folder below");
    }
    media(gltf)["uri"] = "missing.mp4";
    const auto missing = open();
    EXPECT_TRUE(is_refused(missing, "missing.mp4"));
}

TEST_F(GltfClipTest, WhatIsNotReadIsRefusedByName) {
    write(2);
    const Json whole = gltf;
    const Fault faults[] = {
        {[](Json& g) { g.erase("extensions"); }, "no extensions.MPEG_media"},
        {[](Json& g) { frames_of(g, 1)["media"] = 1; }, "a number of one of 1 media"},
        {[](Json& g) { frames_of(g, 1)["tracks"] = {7}; }, "a number of one of 4 tracks"},
        {[](Json& g) {
             frames_of(g, 1)["tracks"] = {1, 2, 3};
         },
         "depth is 3 tracks"},
        {[](Json& g) { g["buffers"][2].erase("extensions"); }, "no MPEG_buffer_circular"},
        {[](Json& g) { media(g)["tracks"][1]["track"] = "#trackID=2"; }, "must be \"#track_ID=N\""},
        {[](Json& g) { media(g)["tracks"][1]["track"] = "#track_ID=0"; },
         "must be \"#track_ID=N\", N from 1"},
        {[](Json& g) { g["textures"][1]["extensions"]["MPEG_texture_video"]["width"] = 0; },
         "a whole number from 1 to 16384"},
        {[](Json& g) { g["textures"][1]["extensions"]["MPEG_texture_video"]["accessor"] = 99; },
         "a number of one of 7 accessors"},
        {[](Json& g) { g["meshes"][0]["extras"]["touchable"]["depth"] = 9; }, "names texture 9, but has 4"},
        {[](Json& g) { g["meshes"][0]["extras"]["touchable"]["scene"]["width"] = -1; }, "width is -1"},
        {[](Json& g) { g["meshes"][0]["extensions"]["MPEG_haptic_material"]["hapticMaterialIndex"] = 4; },
         "a number of one of 1 materials"},
        {[](Json& g) { g["extensions"]["MPEG_haptic_material"]["materials"] = {1e300}; },
         "materials[0] is 1e+300: must be an object"},
        {[](Json& g) { g["extensions"] = 1; }, "extensions is 1: must be an object"},
        {[](Json& g) { g["asset"]["version"] = "3.0"; }, "asset.version is \"3.0\": must be 2.0"},
        {[](Json& g) { material(g)["stiffness"][0]["type"] = "Reference"; }, "type Reference"},
        {[](Json& g) { material(g)["stiffness"][0]["extras"]["touchable_channel"] = 3; },
         "a whole number from 0 to 2"},
        {[](Json& g) { g["textures"][3].erase("extensions"); }, "neither a picture nor a video"},
        {[](Json& g) {
             g["meshes"][0].erase("extras");
             for (auto& texture : g["textures"])
                 texture["extensions"]["MPEG_texture_video"]["format"] = "RED";
         },
         "has no depth"},
    };
    for (const Fault& fault : faults) {
        gltf = whole;
        fault.make(gltf);
        expect_refused(fault.words);
    }
    gltf = whole;
    media(gltf)["tracks"][1]["track"] = "#track_ID=77";
    const auto other = open();
    EXPECT_TRUE(is_refused(other, "depth, track 77, which has no pictures"));
}

TEST_F(GltfClipTest, NamesThatStandForSeveralFilesAreRefused) {
    for (const char* name : {"s 100%d.gltf", "s*.gltf"}) {
        const auto written = write_gltf(folder / name, small_scene(8, 6), 1, {});
        EXPECT_TRUE(is_refused(written, "has a % or * in its name"));
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    write(1);
    write_bytes(folder / "list.txt", "0.0 /etc/hostname\n");
    for (Json& image : gltf["images"])
        if (image["uri"] == "clip_depth.png") image["uri"] = "list.txt";
    expect_refused("stands for several files");
}

TEST_F(GltfClipTest, WhatTouchSaysWronglyIsRefusedWithItsOwnName) {
    write(2);
    const Json whole = gltf;
    material(gltf)["stiffness"][0]["extras"]["touchable_range"] = {5, 1};
    expect_refused("haptic.stiffness");
    gltf = whole;
    material(gltf)["custom"][0]["extras"]["touchable_channel"] = 2;
    expect_refused("its heights are channel 2");
    gltf = whole;
    material(gltf)["custom"][0]["extras"]["touchable_range"] = {1, 2};
    expect_refused("black of its heights must be 0");
}

TEST_F(GltfClipTest, HighAndLowBitsAreTwoTracks) {
    write(2, 16);
    frames_of(gltf, 1)["tracks"] = {1, 1};
    const auto twice = open();
    EXPECT_TRUE(is_refused(twice, "its low bits of depth is the same track as its depth"));
}

/// Each primitive is looked up by itself: in time that grows with their number alone.
TEST_F(GltfClipTest, AHundredThousandMaterialsAreLookedUpInNoTime) {
    write(1);
    constexpr int many = 100'000;
    gltf["meshes"][0].erase("extras");
    gltf["materials"] = Json(many, Json::object());
    gltf["meshes"][0]["primitives"] = Json(many, Json{{"material", 5}});
    expect_refused("has no depth");
}

TEST_F(GltfClipTest, ACutSceneIsRefusedInOneLine) {
    write(1);
    const std::string whole = read_bytes(file);
    int taken = 0;
    for (std::size_t length = 0; length + 2 < whole.size(); length += 1 + whole.size() / 200) {
        write_bytes(file, whole.substr(0, length));
        const auto clip = open_clip(file);
        taken += bool(clip);
        EXPECT_EQ(message(clip).find('\n'), std::string::npos);
    }
    EXPECT_EQ(taken, 0);
}

TEST_F(GltfClipTest, WithoutItsVideoOrAPictureItIsRefused) {
    write(1);
    std::filesystem::remove(folder / "clip_haptic.png");
    const auto still = open();
    EXPECT_TRUE(is_refused(still, "clip_haptic.png"));
}

}  // namespace
}  // namespace touchable::test
