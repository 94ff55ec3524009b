#include "engine/mpeg4/bifs.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/mpeg4/example_scenes.hpp"

namespace touchable::mpeg4 {
namespace {

std::vector<std::uint8_t> encoded(const SceneTree& scene) {
    auto bytes = encode_scene(scene, config_for(scene, 64, 48));
    EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().message);
    return bytes ? *bytes : std::vector<std::uint8_t>();
}

/// Encoded, decoded and written again.
std::string through_bits(std::string_view text) {
    const SceneTree scene = scene_from(text);
    const auto decoded = decode_scene(encoded(scene), config_for(scene, 64, 48));
    EXPECT_TRUE(decoded) << (decoded ? "" : decoded.error().message);
    return decoded ? scene_text(*decoded) : "";
}
std::string as_written(std::string_view text) {
    return scene_text(scene_from(text));
}

TEST(Bifs, PrototypesAreTheBytesOfGpacsEncoder) {
    const SceneTree scene = scene_from(prototype_scene);
    EXPECT_EQ(hex(encoded(scene)), prototype_bytes);
    EXPECT_EQ(hex(encode_config(config_for(scene, 64, 48))), "02017004000300");
}

TEST(Bifs, ADepthImageIsTheBytesOfGpacsEncoder) {
    const SceneTree scene = scene_from(depth_image_scene);
    EXPECT_EQ(hex(encoded(scene)), depth_image_bytes);
    EXPECT_EQ(hex(encode_config(config_for(scene, 64, 48))), "083802000180");
}

TEST(Bifs, StillsAreTheBytesOfGpacsEncoder) {
    const SceneTree still = scene_from(still_scene), image = scene_from(depth_image_still_scene);
    EXPECT_EQ(hex(encoded(still)), still_bytes);
    EXPECT_EQ(hex(encode_config(config_for(still, 720, 480))), "0201702d001e00");
    EXPECT_EQ(hex(encoded(image)), depth_image_still_bytes);
    EXPECT_EQ(hex(encode_config(config_for(image, 720, 480))), "083816800f00");
}

/// As GPAC encodes the same two without names.
TEST(Bifs, NamesPrototypesByTheirFields) {
    const auto decoded = [](std::string_view bytes, const BifsConfig& config) {
        auto scene = decode_scene(bytes_of_hex(bytes), config);
        EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
        return scene ? *scene : SceneTree();
    };
    const BifsConfig still{.prototype_id_bits = 2}, image{.version = 1};
    EXPECT_FALSE(decoded(nameless_still_bytes, still).has_names);
    EXPECT_EQ(scene_text(decoded(nameless_still_bytes, still)), scene_text(decoded(still_bytes, still)));
    EXPECT_EQ(scene_text(decoded(nameless_depth_image_still_bytes, image)),
              scene_text(decoded(depth_image_still_bytes, image)));
}

TEST(Bifs, ScenesComeBack) {
    EXPECT_EQ(through_bits(prototype_scene), as_written(prototype_scene));
    for (
        const std::string_view text : {
            // a prototype that is elsewhere
            R"(EXTERNPROTO Depth [ exposedField SFFloat farPlane exposedField MFString names exposedField SFNode texture ]
                  ["urn:touchable:depth"]
                Group { children [ Shape { geometry Depth { farPlane 3 names ["a" "b"] texture ImageTexture { url "d.png" } } } ] })",
            // pictures that do not move
            R"(Group { children [ WorldInfo { info ["one" "two"] title "a clip" }
                  Shape { appearance Appearance { texture ImageTexture { url ["c.png"] repeatS FALSE } } } ] })",
            // a node that is used again, and lists long enough to be counted
            R"(Group { children [ Shape { appearance DEF look Appearance { texture DEF movie MovieTexture { url [1 2 3 4 5 6 7 8 9 10 11 12] } } }
                  Shape { appearance USE look } Shape { appearance Appearance { texture USE movie } } ] })",
            // one of each type of field, in a prototype
            R"(PROTO All [ field SFBool a TRUE field SFFloat b 0.25 field SFTime c 1.5 field SFString d "say \"hi\"" field SFInt32 e -3
                  field SFVec3f f 1 2 3 field SFVec2f g 4 5 field SFColor h 0.5 0.25 1 field SFRotation i 0 1 0 2 field SFURL j "x.png"
                  field MFFloat k [1 2 3 4 5 6 7 8 9] field MFInt32 l [] field MFURL m [7 "y.png"] field MFNode n [] ] { WorldInfo { title IS d } }
                Group { children [ All { a FALSE b 1e-6 c 1e9 d "" e 2147483647 f 0 0 1 g -1 0 h 0 0 0 i 1 0 0 3 j 1023
                  k [0.1] l [1 2] m [] n [WorldInfo {} All {}] } ] })",
        })
        EXPECT_EQ(through_bits(text), as_written(text));
}

TEST(Bifs, WhatIsThePapersOwnHasNoBinaryForm) {
    const auto refusal = [](std::string_view text) {
        const SceneTree scene = scene_from(text);
        const auto bytes = encode_scene(scene, config_for(scene, 64, 48));
        return bytes ? std::string("no error") : bytes.error().message;
    };
    EXPECT_EQ(refusal("Group { children [ Shape { geometry Depth {} } ] }"),
              "Group: Shape: Depth: MPEG-4 has no such node; a PROTO could define it");
    EXPECT_EQ(refusal("Group { children [ Shape { appearance Appearance { hapticSurface HapticTextureSurface "
                      "{} } } ] }"),
              "Group: Shape: Appearance.hapticSurface: MPEG-4 has no such field; a PROTO could define it");
    EXPECT_EQ(refusal("Shape {}"), "Shape: MPEG-4 has no such node there");
}

TEST(Bifs, ASceneThatIsCutIsRefused) {
    const SceneTree scene = scene_from(prototype_scene);
    const auto bytes = encoded(scene);
    for (std::size_t length = 0; length + 1 < bytes.size(); ++length) {
        const auto decoded = decode_scene(std::span(bytes).first(length), config_for(scene, 64, 48));
        ASSERT_FALSE(decoded) << length;
        EXPECT_EQ(decoded.error().kind, ErrorKind::input);
    }
    auto longer = bytes;
    longer.push_back(0);
    EXPECT_TRUE(decode_scene(longer, config_for(scene, 64, 48)));
}

TEST(Bifs, DamageNamesItsBit) {
    const SceneTree scene = scene_from(prototype_scene);
    const auto bytes = encoded(scene);
    int refused = 0, opened = 0;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        auto damaged = bytes;
        damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (128 >> bit % 8));
        const auto decoded = decode_scene(damaged, config_for(scene, 64, 48));
        if (decoded) {
            ++opened;
            EXPECT_TRUE(parse_scene_text(scene_text(*decoded))) << scene_text(*decoded);
        } else {
            ++refused;
            const std::string& why = decoded.error().message;
            EXPECT_TRUE(why.starts_with("bit ") || why == "the scene ends within a node") << why;
        }
    }
    EXPECT_GT(refused, 100);
    EXPECT_GT(opened, 100);  // another number, another letter
}

/// A scene of prototypes and fields as somebody may write it who wants to do harm.
TEST(Bifs, LimitsHold) {
    const auto refusal = [](std::vector<std::uint8_t> bytes, BifsConfig config = {.prototype_id_bits = 2}) {
        const auto decoded = decode_scene(bytes, config);
        return decoded ? std::string("no error") : decoded.error().message;
    };
    EXPECT_EQ(refusal(std::vector<std::uint8_t>(70'000)),
              "the scene has 70000 bytes: must be 64 KiB at most");
    EXPECT_EQ(refusal({0x40}), "bit 2: an update of a scene: must be one that begins it (SceneReplace)");
    std::string deep;
    for (int k = 0; k < 40; ++k) deep += "Group { children [ ";
    const auto text = parse_scene_text(deep);
    ASSERT_FALSE(text);
    EXPECT_NE(text.error().message.find("more than 32 deep"), std::string::npos) << text.error().message;
    // Group { children [ Group { children [ ..., each 13 bits: new, 3D, 17, unnamed, mask, children, list,
    // value.
    std::string bits =
        "11000000"
        "1"
        "0"
        "0"
        "001"
        "0"
        "1"
        "1"
        "0"
        "1";
    for (int k = 0; k < 40; ++k)
        bits +=
            "0"
            "0"
            "010001"
            "0"
            "1"
            "1"
            "0"
            "1";
    std::vector<std::uint8_t> bytes((bits.size() + 7) / 8);
    for (std::size_t k = 0; k < bits.size(); ++k)
        if (bits[k] == '1') bytes[k / 8] = static_cast<std::uint8_t>(bytes[k / 8] | (128 >> k % 8));
    EXPECT_NE(refusal(bytes).find("more than 32 deep"), std::string::npos) << refusal(bytes);
}

TEST(Bifs, NumbersThatFourBytesCannotHoldAreRefused) {
    SceneTree scene = scene_from("Shape { geometry Rectangle { size 3 4 } }");
    auto& size = std::get<NodePtr>(scene.root->fields[0].values[0])->fields[0].values[0];
    size = std::array{1.0F, std::numeric_limits<float>::infinity()};
    scene.root = std::make_shared<Node>(Node{.type = "Group", .fields = {{"children", {scene.root}}}});
    const auto refused = encode_scene(scene, config_for(scene, 64, 48));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message, "Group: Shape: Rectangle: has a number that four bytes cannot hold");
}

TEST(Bifs, NodesWithNamesMayStandInPrototypesFields) {
    constexpr std::string_view scene =
        "PROTO Held [ exposedField SFNode inner DEF kept WorldInfo { title \"a\" } ] { WorldInfo {} }\n"
        "Group { children [ Held {} DEF kept WorldInfo { title \"b\" } USE kept ] }";
    EXPECT_EQ(through_bits(scene), as_written(scene));
}

TEST(Bifs, ConfigurationsComeBack) {
    for (const BifsConfig& config :
         {BifsConfig{.version = 1, .node_id_bits = 3, .width = 640, .height = 480},
          BifsConfig{.node_id_bits = 9, .route_id_bits = 2, .prototype_id_bits = 4}}) {
        const auto read = decode_config(encode_config(config), config.object_type());
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ(encode_config(*read), encode_config(config));
    }
    EXPECT_FALSE(decode_config(std::vector<std::uint8_t>{1}, 2));
    EXPECT_FALSE(decode_config(std::vector<std::uint8_t>{8, 0x38, 2, 0, 1, 0x80}, 3));
}

}  // namespace
}  // namespace touchable::mpeg4
