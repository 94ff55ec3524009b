// What we write against the properties that ISO/IEC 23090-14 gives each of its extensions: names, types,
// which are required, and that what they point to is there.
#include <map>
#include <set>

#include "tests/gltf/gltf_fixture.hpp"

namespace touchable::test {
namespace {

using Json = nlohmann::json;

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
    EXPECT_FALSE(gltf.contains("extensionsRequired"));  // whoever knows none of them shows the still
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

TEST_F(GltfClipTest, AVideoHasThePropertiesOfTheStandard) {
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

TEST_F(GltfClipTest, AStillHasPicturesAlone) {
    write(1, 12);
    expect_listed_extensions(gltf);
    EXPECT_FALSE(gltf["extensions"].contains("MPEG_media"));
    expect_haptic_material(gltf);
    for (const Json& texture : gltf["textures"]) {
        EXPECT_FALSE(texture.contains("extensions"));
        const Json& image = at(gltf["images"], texture["source"]);
        EXPECT_TRUE(std::filesystem::exists(folder / image["uri"].get<std::string>()));
    }
}

/// glTF 2.0 itself: views lie in their buffers, and a buffer is as long as its file.
TEST_F(GltfClipTest, TheMeshLiesInItsBuffer) {
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

}  // namespace
}  // namespace touchable::test
