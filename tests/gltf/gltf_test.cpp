// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "engine/formats/formats_written.hpp"
#include "engine/formats/gltf_writer.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

Result<void> write_gltf(const fs::path& file, const SceneDescription& described, int frames,
                        const Planes& planes, Existing existing = Existing::keep) {
    return write_all(create_gltf_clip(file, described, frames == 1, exact_clip, existing),
                     test_frames(described.scene, frames, planes));
}

Json& media(Json& gltf) {
    return gltf["extensions"]["MPEG_media"]["media"][0]["alternatives"][0];
}
Json& frames_of(Json& gltf, std::size_t plane) {  // buffer 0 is the mesh's
    return gltf["buffers"][plane + 1]["extensions"]["MPEG_buffer_circular"];
}
Json& material(Json& gltf) {
    return gltf["extensions"]["MPEG_haptic_material"]["materials"][0];
}

/// Removes what other programs do not write.
void forget_extras(Json& node) {
    if (node.is_object()) node.erase("extras");
    for (auto& child : node)
        if (child.is_structured()) forget_extras(child);
}

/// A clip of small pictures as glTF, of which a test changes the text.
class GltfClip : public ::testing::Test {
protected:
    void write(int frames, int depth_bits = 8, const Planes& planes = all_planes) {
        scene = small_scene(24, 16, depth_bits);
        scene.height_coding.max_height = 1.5;
        scene.haptic.stiffness = {0.25, 1.5};
        ASSERT_EQ(message(write_gltf(file, scene, frames, planes)), "");
        gltf = Json::parse(read_bytes(file));
    }
    /// One more texture, number 4, of one grey.
    void add_picture(const std::string& name, int width, int height, std::uint8_t grey) {
        const Image picture{width, height, 1, 1,
                            std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), grey)};
        ASSERT_TRUE(write_png(folder / name, picture.view()));
        gltf["images"].push_back({{"uri", name}});
        gltf["textures"].push_back({{"source", 1}});
    }
    /// As it is now.
    Result<std::unique_ptr<ClipReader>> open() const {
        write_bytes(file, gltf.dump());
        return open_clip(file);
    }
    void expect_refused(const std::string& words) const {
        const auto clip = open();
        EXPECT_TRUE(is_refused(clip, words));
        EXPECT_TRUE(is_one_line_about(file, clip));
    }
    TemporaryFolder folder;
    fs::path file = folder / "clip.gltf";
    Scene scene;
    Json gltf;
};

// A clip that was written as a glTF scene comes back; so does what other programs could have written.

void expect_comes_back(const fs::path& file, const Scene& scene, int frames, const Planes& planes) {
    ASSERT_EQ(message(write_gltf(file, scene, frames, planes, Existing::replace)), "");
    expect_clip(file, scene, test_frames(scene, frames, planes), frames > 1);
}

TEST(GltfRoundTrip, KeepsEveryBit) {
    const TemporaryFolder folder;
    for (const int frames : {1, 3})
        for (const int bits : {8, 10, 12, 16})
            expect_comes_back(folder / "a clip é.gltf", scene_with_heights(63, 47, bits, bits == 12 ? 16 : 8),
                              frames, all_planes);
}

TEST(GltfRoundTrip, KeepsAnyChoiceOfPlanes) {
    const TemporaryFolder folder;
    for (const int frames : {1, 2})
        for (int choice = 0; choice < 8; ++choice)
            expect_comes_back(folder / "clip.gltf", scene_with_heights(63, 47, 16, 8), frames,
                              {(choice & 1) != 0, (choice & 2) != 0, (choice & 4) != 0});
}

TEST_F(GltfClip, WritesAllFilesOrNone) {
    write(2);
    const auto files = [this] {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder.path()))
            names.push_back(entry.path().filename());
        std::sort(names.begin(), names.end());
        return names;
    };
    EXPECT_EQ(files(), (std::vector<std::string>{"clip.bin", "clip.gltf", "clip.mp4", "clip.png"}));
    for (const char* name : {"clip.gltf", "clip.png"}) fs::remove(folder / name);
    const std::string before = read_bytes(folder / "clip.mp4");
    EXPECT_TRUE(is_refused(write_gltf(file, scene, 3, all_planes), "cannot be written: File exists"));
    EXPECT_EQ(files(), (std::vector<std::string>{"clip.bin", "clip.mp4"}));
    EXPECT_EQ(read_bytes(folder / "clip.mp4"), before);
    EXPECT_EQ(message(write_gltf(file, scene, 3, all_planes, Existing::replace)), "");
    EXPECT_EQ(message(open_clip(file)), "");
}

/// Also what only other programs show.
TEST_F(GltfClip, ListsItsFiles) {
    write(2);
    const auto clip = must(open());
    const auto& inputs = clip->inputs();
    for (const char* name : {"clip.mp4", "clip.gltf", "clip.bin", "clip.png"})
        EXPECT_NE(std::find(inputs.begin(), inputs.end(), folder / name), inputs.end()) << name;
    EXPECT_EQ(sound_file_of(*clip), folder / "clip.mp4");
}

TEST_F(GltfClip, ReadsRangesBesideTexture) {
    write(2);
    auto& stiffness = material(gltf)["stiffness"][0];
    stiffness["extras"]["touchable_range"] = {0.5, 0.75};
    const auto clip = must(open());
    EXPECT_EQ(clip->scene().haptic.stiffness.min, 0.5);
    EXPECT_EQ(clip->scene().haptic.stiffness.max, 0.75);
    EXPECT_TRUE(is_noted(*clip, "the material's stand"));
}

TEST_F(GltfClip, NotesAssumptionsOfForeignFile) {
    write(2);
    forget_extras(gltf);
    material(gltf).erase("friction");
    const auto clip = must(open());
    const Scene& found = clip->scene();
    EXPECT_EQ(found.depth.near, 0.5);
    EXPECT_EQ(found.depth.far, 1.5);
    EXPECT_FALSE(found.depth.near_is_high);
    EXPECT_EQ(found.haptic.static_friction.min, found.default_properties.static_friction);
    EXPECT_EQ(found.haptic.static_friction.max, found.default_properties.static_friction);
    for (const char* words : {"states no units", "0.5 m, black, to 1.5 m", "60 degrees"})
        EXPECT_TRUE(is_noted(*clip, words)) << words;
    const auto frame = must(clip->next());
    const RawFrame whole = test_frame(scene, 0, all_planes);
    EXPECT_TRUE(same_plane(frame->depth, whole.depth));
    EXPECT_TRUE(same_plane(frame->colour, whole.colour));
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 24; ++x)
            ASSERT_EQ(frame->haptic.sample(x, y, 0), whole.haptic.sample(x, y, 0)) << x << ' ' << y;
    EXPECT_TRUE(frame->height.empty());
}

TEST_F(GltfClip, ReadsHeightBesideTexture) {
    write(2);
    auto& height = material(gltf)["custom"][0];
    height["extras"]["touchable_range"] = {0, 0.002};
    const auto clip = must(open());
    EXPECT_NEAR(largest_height(clip->scene().height_coding, clip->scene().depth), 2.0, 1e-12);
    EXPECT_TRUE(is_noted(*clip, "the material's stand"));
}

TEST_F(GltfClip, NotesUnusedProperties) {
    write(2);
    material(gltf)["vibration"] = Json::array();
    material(gltf)["stiffness"][0]["texture"]["extensions"] = {
        {"KHR_texture_transform", {{"scale", {2, 2}}}}};
    const auto clip = must(open());
    for (const char* words : {"vibration of ", "KHR_texture_transform of "})
        EXPECT_TRUE(is_noted(*clip, words)) << words;
}

TEST_F(GltfClip, ReadsSlidingFrictionAlone) {
    write(2);
    material(gltf).erase("stiffness");
    material(gltf)["friction"].erase(0);
    const auto clip = must(open());
    EXPECT_EQ(clip->scene().haptic.dynamic_friction.max, scene.haptic.dynamic_friction.max);
    EXPECT_EQ(clip->scene().haptic.static_friction.min, scene.default_properties.static_friction);
}

/// As the standard has it: a texture each, one friction, no "extras". Here they are the videos of haptic and
/// height, which have 3 and 1 channels.
TEST_F(GltfClip, ReadsPropertiesAsOwnVideos) {
    write(3);
    forget_extras(gltf);
    material(gltf) = {{"stiffness", {{{"texture", {{"index", 3}}}, {"type", "High_Resolution"}}}},
                      {"friction", {{{"texture", {{"index", 2}}}, {"type", "High_Resolution"}}}}};
    const auto clip = must(open());
    for (const char* words : {"states no units", "is static and dynamic friction alike", "frame by frame"})
        EXPECT_TRUE(is_noted(*clip, words)) << words;
    EXPECT_FALSE(is_noted(*clip, "no haptic plane"));
    const auto expect_frame = [&](const RawFrame& frame, int n) {
        const RawFrame whole = test_frame(scene, n, all_planes);
        EXPECT_TRUE(same_plane(frame.depth, whole.depth));
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 24; ++x) {
                ASSERT_EQ(frame.haptic.sample(x, y, 0), whole.height.sample(x, y))
                    << n << ' ' << x << ' ' << y;
                ASSERT_EQ(frame.haptic.sample(x, y, 1), whole.haptic.sample(x, y, 0));
                ASSERT_EQ(frame.haptic.sample(x, y, 2), whole.haptic.sample(x, y, 0));
            }
    };
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 3U);
    for (int n = 0; n < 3; ++n) expect_frame(frames[static_cast<std::size_t>(n)], n);
    ASSERT_EQ(message(clip->seek(1)), "");
    expect_frame(next_of(*clip), 1);
}

/// A picture of friction under every frame, beside a video of stiffness.
TEST_F(GltfClip, ReadsPropertyAsPicture) {
    write(2);
    forget_extras(gltf);
    add_picture("slippery.png", 12, 8, 77);
    material(gltf)["friction"] = {{{"texture", {{"index", 4}}}, {"type", "High_Resolution"}}};
    const auto clip = must(open());
    EXPECT_TRUE(is_noted(*clip, "haptic is 12x8: resampled to the nearest pixel of depth's 24x16"));
    const auto frames = must(read_all(*clip));
    for (std::size_t n = 0; n < 2; ++n) {
        const RawFrame whole = test_frame(scene, static_cast<int>(n), all_planes);
        EXPECT_EQ(frames[n].haptic.sample(7, 5, 0), whole.haptic.sample(7, 5, 0));
        EXPECT_EQ(frames[n].haptic.sample(7, 5, 1), 77);
        EXPECT_EQ(frames[n].haptic.sample(7, 5, 2), 77);
    }
}

/// A track that is not there, and a file that is none.
TEST_F(GltfClip, RejectsMissingVideosOfTouch) {
    write(2);
    forget_extras(gltf);
    material(gltf).erase("friction");
    media(gltf)["tracks"][2]["track"] = "#track_ID=77";
    EXPECT_TRUE(is_refused(open(), "has no pictures in track 77"));
    frames_of(gltf, 2)["tracks"] = {1, 2};
    EXPECT_TRUE(is_refused(open(), "a texture of touch is 2 tracks"));
}

/// As .glb files have it.
TEST_F(GltfClip, IgnoresColourPictureBesideVideo) {
    write(2);
    forget_extras(gltf);
    material(gltf).erase("friction");
    gltf["images"][0] = {{"bufferView", 0}};
    gltf["textures"][0].erase("extensions");
    const auto clip = must(open());
    EXPECT_TRUE(next_of(*clip).colour.empty());
}

TEST_F(GltfClip, AcceptsItsSceneAsFile) {
    write(2, 12);
    const auto own = must(guess_clip(file, {}));
    EXPECT_EQ(own.scene.depth_bits, 12);
    write_bytes(folder / "scene.json", scene_to_json(own));
    EXPECT_EQ(message(open_clip(file, folder / "scene.json")), "");
    forget_extras(gltf);
    material(gltf).erase("friction");
    ASSERT_FALSE(open());  // nothing says how many bits its two tracks have
    EXPECT_EQ(message(open_clip(file, folder / "scene.json")), "");
}

TEST_F(GltfClip, ReadsNamesOfTheDraft) {
    write(2);
    auto& all = gltf["extensions"];
    all["MPEG_material_haptic"] = all["MPEG_haptic_material"]["materials"];
    all.erase("MPEG_haptic_material");
    auto& mesh = gltf["meshes"][0]["extensions"];
    mesh = {{"MPEG_material_haptic", 0}};
    const auto clip = must(open());
    EXPECT_FALSE(next_of(*clip).haptic.empty());
}

/// Stiffness and friction as pictures of their own, under every frame of a video.
TEST_F(GltfClip, AppliesPicturesToAllFrames) {
    write(3);
    add_picture("stiff.png", 24, 16, 51);
    material(gltf).erase("friction");
    material(gltf)["stiffness"][0]["texture"]["index"] = 4;
    const auto clip = must(open());
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 3U);
    for (const RawFrame& frame : frames) {
        EXPECT_EQ(frame.haptic.sample(5, 5, 0), 51);
        EXPECT_FALSE(frame.height.empty());
    }
}

/// A file for each plane, without a list of tracks.
TEST_F(GltfClip, ReadsDepthAsOwnVideo) {
    write(2, 8, {.noisy = false});
    media(gltf).erase("tracks");
    for (auto& buffer : gltf["buffers"])
        if (buffer.contains("extensions")) buffer["extensions"]["MPEG_buffer_circular"].erase("tracks");
    const auto clip = must(open());
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_TRUE(same_plane(frames[1].depth, test_frame(scene, 1, {.noisy = false}).depth));
}

// The still surface that programs show which know no depth video.

/// Depth by a function of the pixel.
template <class Code>
FallbackMesh mesh_of(const Scene& scene, const Code& code) {
    Samples samples;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) samples.push_back(static_cast<std::uint8_t>(code(x, y)));
    RawFrame frame;
    frame.depth = {samples.data(), scene.width, scene.width, scene.height, 1, 1};
    return fallback_mesh(frame, scene);
}

TEST(FallbackMesh, PlacesVerticesByCamera) {
    Scene scene = small_scene(300, 200);
    scene.depth.semantics = DepthSemantics::planar;
    const auto mesh = mesh_of(scene, [](int, int) { return 255; });  // near: 10 units, 10 mm
    EXPECT_EQ(mesh.positions.size(), 97U * 65U);
    EXPECT_EQ(mesh.triangles.size(), 2U * 96U * 64U);
    for (const auto& position : mesh.positions) EXPECT_FLOAT_EQ(position[2], -0.01F);
    EXPECT_FLOAT_EQ(mesh.positions.front()[0], -0.01F * 150 / 50);  // pixel 0 of a camera with cx 150, fx 50
    EXPECT_FLOAT_EQ(mesh.positions.front()[1], 0.01F * 100 / 50);
    EXPECT_NEAR(mesh.texture_places.back()[0], 299.5 / 300, 1e-6);
    for (const auto& [a, b, c] : mesh.triangles) {  // counter-clockwise
        const auto &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        EXPECT_GT((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]), 0);
    }
}

TEST(FallbackMesh, SpansNoEdgeOrHole) {
    Scene scene = small_scene(96, 64);
    scene.depth.invalid_codes[0] = 0;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    const auto mesh = mesh_of(scene, [](int x, int y) { return y < 8 ? 0 : x < 48 ? 250 : 20; });
    ASSERT_FALSE(mesh.triangles.empty());
    for (const auto& triangle : mesh.triangles) {
        int near = 0;
        for (const std::uint32_t corner : triangle) {
            const auto& [x, y, z] = mesh.positions[corner];
            near += std::hypot(x, y, z) < 0.05;
            EXPECT_GE(mesh.texture_places[corner][1], 8.0F / 64) << "in the hole";
        }
        EXPECT_TRUE(near == 0 || near == 3) << "across the edge";
    }
}

TEST(FallbackMesh, FollowsSilhouettes) {
    const Scene scene = small_scene(300, 200);
    const auto is_near = [](int x, int y) { return std::hypot(x - 140.3, y - 90.7) < 50; };
    const auto mesh = mesh_of(scene, [&](int x, int y) { return is_near(x, y) ? 250 : 20; });
    EXPECT_LT(mesh.positions.size(), 20'000U) << "fine everywhere";
    std::set<std::pair<int, int>> near_vertices;
    for (std::size_t k = 0; k < mesh.positions.size(); ++k)
        if (mesh.positions[k][2] > -0.5F * static_cast<float>(scene.depth.far * scene.metres_per_unit))
            near_vertices.emplace(std::lround(300 * mesh.texture_places[k][0] - 0.5F),
                                  std::lround(200 * mesh.texture_places[k][1] - 0.5F));
    for (int y = 30; y < 150; ++y)
        for (int x = 80; x < 200; ++x) {
            const bool is_last = is_near(x, y) && !(is_near(x + 1, y) && is_near(x - 1, y));
            EXPECT_FALSE(is_last && !near_vertices.contains({x, y})) << x << ", " << y;
        }
}

/// From the clip's own camera: each cell has its two triangles, and each vertex lies behind its place in the
/// picture.
TEST(FallbackMesh, LeavesNoGapAtSilhouettes) {
    const Scene scene = small_scene(96, 64);
    const auto mesh =
        mesh_of(scene, [](int x, int y) { return x > 30 && x < 60 && y > 20 && y < 50 ? 250 : 20; });
    EXPECT_EQ(mesh.triangles.size(), 2U * 95U * 63U);
    for (std::size_t k = 0; k < mesh.positions.size(); ++k) {
        const auto& [x, y, z] = mesh.positions[k];
        const double across = scene.camera.cx - scene.camera.fx * x / z,
                     down = scene.camera.cy + scene.camera.fy * y / z;
        EXPECT_NEAR(across, 96 * mesh.texture_places[k][0] - 0.5, 1e-3);
        EXPECT_NEAR(down, 64 * mesh.texture_places[k][1] - 0.5, 1e-3);
    }
}

TEST(FallbackMesh, IsRectangleWithoutDepth) {
    Scene scene = small_scene(20, 10);
    scene.depth.invalid_codes[0] = 7;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    const auto mesh = mesh_of(scene, [](int, int) { return 7; });
    EXPECT_EQ(mesh.positions.size(), 4U);
    EXPECT_EQ(mesh.triangles.size(), 2U);
}

// What we write against the properties that ISO/IEC 23090-14 gives each of its extensions: names, types,
// which are required, and that what they point to is there.

enum class Kind { whole, number, text, flag, object, list, numbers };

bool is_of(const Json& value, Kind kind) {
    switch (kind) {
        case Kind::whole:
            return value.is_number_integer() && value >= 0;
        case Kind::number:
            return value.is_number();
        case Kind::text:
            return value.is_string() && !value.get<std::string>().empty();
        case Kind::flag:
            return value.is_boolean();
        case Kind::object:
            return value.is_object() && !value.empty();
        case Kind::list:
            return value.is_array() && !value.empty();
        case Kind::numbers:
            return value.is_array() && !value.empty() && value[0].is_number_integer();
    }
    return false;
}

struct Property {
    Kind kind;
    bool is_required = false;
};
using Properties = std::map<std::string, Property>;

const Properties media_properties{{"name", {Kind::text}},
                                  {"startTime", {Kind::number}},
                                  {"startTimeOffset", {Kind::number}},
                                  {"endTimeOffset", {Kind::number}},
                                  {"autoplay", {Kind::flag}},
                                  {"autoplayGroup", {Kind::whole}},
                                  {"loop", {Kind::flag}},
                                  {"controls", {Kind::flag}},
                                  {"alternatives", {Kind::list, true}}};
const Properties alternative_properties{{"uri", {Kind::text, true}},
                                        {"mimeType", {Kind::text, true}},
                                        {"tracks", {Kind::list}},
                                        {"extraParams", {Kind::object}}};
const Properties track_properties{{"track", {Kind::text, true}}, {"codecs", {Kind::text, true}}};
const Properties buffer_properties{
    {"media", {Kind::whole, true}}, {"count", {Kind::whole}}, {"tracks", {Kind::numbers}}};
const Properties accessor_properties{
    {"immutable", {Kind::flag}}, {"bufferView", {Kind::whole}}, {"suggestedUpdateRate", {Kind::number}}};
const Properties texture_properties{{"accessor", {Kind::whole, true}},
                                    {"width", {Kind::number, true}},
                                    {"height", {Kind::number, true}},
                                    {"format", {Kind::text}}};
const Properties material_properties{{"name", {Kind::text}},        {"haptic", {Kind::whole}},
                                     {"stiffness", {Kind::list}},   {"friction", {Kind::list}},
                                     {"vibration", {Kind::list}},   {"vibrotactileTexture", {Kind::list}},
                                     {"temperature", {Kind::list}}, {"custom", {Kind::list}}};
const Properties haptic_texture_properties{
    {"texture", {Kind::object, true}}, {"type", {Kind::text, true}}, {"extras", {Kind::object}}};

void expect_properties(const Json& node, const Properties& properties, const std::string& where) {
    ASSERT_TRUE(node.is_object()) << where;
    for (const auto& item : node.items()) {
        const auto known = properties.find(item.key());
        ASSERT_NE(known, properties.end()) << where << " has " << item.key();
        EXPECT_TRUE(is_of(item.value(), known->second.kind)) << where << '.' << item.key();
    }
    for (const auto& [name, property] : properties)
        EXPECT_TRUE(!property.is_required || node.contains(name)) << where << " lacks " << name;
}

/// Every name below a member "extensions".
void gather(const Json& node, std::set<std::string>& names) {
    if (node.is_object() && node.contains("extensions"))
        for (const auto& item : node["extensions"].items()) names.insert(item.key());
    for (const auto& child : node)
        if (child.is_structured()) gather(child, names);
}

void expect_listed_extensions(const Json& gltf) {
    std::set<std::string> used, listed;
    gather(gltf, used);
    for (const auto& name : gltf["extensionsUsed"]) EXPECT_TRUE(listed.insert(name).second) << name;
    EXPECT_EQ(used, listed);
    EXPECT_FALSE(gltf.contains("extensionsRequired"));  // a program that knows none of them shows the still
}

const Json& at(const Json& array, const Json& index) {
    EXPECT_LT(index.get<std::size_t>(), array.size());
    return array.at(index.get<std::size_t>());
}

/// From a texture to the tracks that it is made of.
void expect_video(const Json& gltf, const Json& texture, std::size_t bytes_per_pixel) {
    const Json& video = texture["extensions"]["MPEG_texture_video"];
    expect_properties(video, texture_properties, "MPEG_texture_video");
    EXPECT_TRUE((std::set<std::string>{"RED", "RGB", "DEPTH_COMPONENT"}.contains(video["format"])));
    const Json& accessor = at(gltf["accessors"], video["accessor"]);
    expect_properties(accessor["extensions"]["MPEG_accessor_timed"], accessor_properties,
                      "MPEG_accessor_timed");
    const std::size_t pixels = 24 * 16;
    EXPECT_EQ(accessor["count"], pixels);
    const Json& view = at(gltf["bufferViews"], accessor["bufferView"]);
    const Json& buffer = at(gltf["buffers"], view["buffer"]);
    EXPECT_EQ(buffer["byteLength"], pixels * bytes_per_pixel);
    EXPECT_EQ(view["byteLength"], buffer["byteLength"]);
    const Json& frames = buffer["extensions"]["MPEG_buffer_circular"];
    expect_properties(frames, buffer_properties, "MPEG_buffer_circular");
    EXPECT_GE(frames["count"], 2);
    const Json& media = at(gltf["extensions"]["MPEG_media"]["media"], frames["media"]);
    for (const Json& track : frames["tracks"]) at(media["alternatives"][0]["tracks"], track);
}

void expect_media(const Json& media) {
    expect_properties(media, media_properties, "MPEG_media");
    EXPECT_NE(media.contains("autoplay"), media.contains("startTime"));  // exactly one of them
    for (const Json& alternative : media["alternatives"]) {
        expect_properties(alternative, alternative_properties, "alternatives");
        EXPECT_EQ(alternative["mimeType"], "video/mp4");
        for (const Json& track : alternative["tracks"]) {
            expect_properties(track, track_properties, "tracks");
            EXPECT_EQ(track["codecs"].get<std::string>().find("avc1."), 0U);
        }
    }
}

void expect_haptic_material(const Json& gltf) {
    const Json& materials = gltf["extensions"]["MPEG_haptic_material"]["materials"];
    ASSERT_EQ(materials.size(), 1U);
    expect_properties(materials[0], material_properties, "MPEG_haptic_material");
    for (const char* property : {"stiffness", "friction", "custom"})
        for (const Json& texture : materials[0][property]) {
            expect_properties(texture, haptic_texture_properties, property);
            at(gltf["textures"], texture["texture"]["index"]);
            EXPECT_TRUE((std::set<std::string>{"High_Resolution", "Other"}.contains(texture["type"])));
        }
    const Json& mesh = gltf["meshes"][0]["extensions"]["MPEG_haptic_material"];
    expect_properties(mesh, {{"hapticMaterialIndex", {Kind::whole, true}}}, "the mesh");
    at(materials, mesh["hapticMaterialIndex"]);
}

TEST_F(GltfClip, VideoFollowsTheStandard) {
    write(2, 12);
    expect_listed_extensions(gltf);
    for (const Json& media : gltf["extensions"]["MPEG_media"]["media"]) expect_media(media);
    ASSERT_EQ(gltf["textures"].size(), 4U);
    const std::size_t bytes[] = {3, 2, 3, 1};  // colour, depth, haptic, height
    for (std::size_t k = 0; k < 4; ++k) expect_video(gltf, gltf["textures"][k], bytes[k]);
    const Json& depth = gltf["textures"][1]["extensions"]["MPEG_texture_video"];
    EXPECT_EQ(depth["format"], "DEPTH_COMPONENT");
    EXPECT_EQ(at(gltf["accessors"], depth["accessor"])["componentType"], 5123);
    expect_haptic_material(gltf);
    EXPECT_EQ(gltf["textures"][0]["source"], 0);
}

TEST_F(GltfClip, StillHasPicturesAlone) {
    write(1, 12);
    expect_listed_extensions(gltf);
    EXPECT_FALSE(gltf["extensions"].contains("MPEG_media"));
    expect_haptic_material(gltf);
    for (const Json& texture : gltf["textures"]) {
        EXPECT_FALSE(texture.contains("extensions"));
        const Json& image = at(gltf["images"], texture["source"]);
        EXPECT_TRUE(fs::exists(folder / image["uri"].get<std::string>()));
    }
}

/// glTF 2.0 itself: views lie in their buffers, and a buffer is as long as its file.
TEST_F(GltfClip, KeepsMeshInItsBuffer) {
    write(2);
    const std::size_t bytes = gltf["buffers"][0]["byteLength"];
    EXPECT_EQ(read_bytes(folder / "clip.bin").size(), bytes);
    std::size_t end = 0;
    for (const Json& view : gltf["bufferViews"])
        if (view["buffer"] == 0) {
            EXPECT_EQ(view["byteOffset"], end);
            end += view["byteLength"].get<std::size_t>();
        }
    EXPECT_EQ(end, bytes);
    const Json& primitive = gltf["meshes"][0]["primitives"][0];
    const Json& indices = at(gltf["accessors"], primitive["indices"]);
    const Json& positions = at(gltf["accessors"], primitive["attributes"]["POSITION"]);
    EXPECT_EQ(indices["count"].get<std::size_t>() % 3, 0U);
    const std::string mesh = read_bytes(folder / "clip.bin");
    for (std::size_t k = 0; k < indices["count"].get<std::size_t>(); ++k) {
        std::uint32_t corner = 0;
        std::memcpy(&corner, mesh.data() + 4 * k, 4);
        ASSERT_LT(corner, positions["count"].get<std::size_t>());
    }
}

// glTF scenes that are damaged, or that ask for what is not read, are refused in one line.

struct Fault {
    std::function<void(Json&)> make;
    const char* words;
};

TEST_F(GltfClip, ReadsOnlyFilesBesideIt) {
    write(2);
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
    EXPECT_TRUE(is_refused(open(), "missing.mp4"));
}

TEST_F(GltfClip, NamesUnreadableContent) {
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
    EXPECT_TRUE(is_refused(open(), "depth, track 77, which has no pictures"));
}

TEST_F(GltfClip, RejectsNamesOfSeveralFiles) {
    for (const char* name : {"s 100%d.gltf", "s*.gltf"}) {
        EXPECT_TRUE(
            is_refused(write_gltf(folder / name, small_scene(8, 6), 1, {}), "has a % or * in its name"));
    }
    EXPECT_TRUE(fs::is_empty(folder.path()));
    write(1);
    write_bytes(folder / "list.txt", "0.0 /etc/hostname\n");
    for (Json& image : gltf["images"])
        if (image["uri"] == "clip_depth.png") image["uri"] = "list.txt";
    expect_refused("stands for several files");
}

TEST_F(GltfClip, NamesInvalidTouchProperty) {
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

TEST_F(GltfClip, RejectsSharedTrackOfBits) {
    write(2, 16);
    frames_of(gltf, 1)["tracks"] = {1, 1};
    EXPECT_TRUE(is_refused(open(), "its low bits of depth is the same track as its depth"));
}

/// Each primitive is looked up by itself: in time that grows with their number alone.
TEST_F(GltfClip, LooksUpManyMaterialsQuickly) {
    write(1);
    constexpr int many = 100'000;
    gltf["meshes"][0].erase("extras");
    gltf["materials"] = Json(many, Json::object());
    gltf["meshes"][0]["primitives"] = Json(many, Json{{"material", 5}});
    expect_refused("has no depth");
}

TEST_F(GltfClip, RejectsCutFile) {
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

TEST_F(GltfClip, NamesMissingPicture) {
    write(1);
    fs::remove(folder / "clip_haptic.png");
    EXPECT_TRUE(is_refused(open(), "clip_haptic.png"));
}

}  // namespace
}  // namespace touchable::test
