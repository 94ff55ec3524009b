#include "engine/mpeg4/clip_scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "engine/mpeg4/bifs.hpp"
#include "engine/scene/scene.hpp"
#include "tests/mpeg4/example_scenes.hpp"

namespace touchable::mpeg4 {
namespace {

/// One that nodes can say whole.
Scene papers_clip() {
    Scene scene;
    scene.width = 64;
    scene.height = 48;
    scene.camera = camera_from_focal_length(50, 1, 64, 48);
    scene.depth.near = 10;
    scene.depth.far = 200;
    derive_valid_range(scene.depth);
    scene.height_coding.max_height = 2;
    scene.haptic.stiffness = {0.2, 7};
    return scene;
}

TEST(ClipScene, WhatNodesCannotSayIsSaid) {
    EXPECT_TRUE(unsaid_by_nodes(papers_clip()).empty());
    const std::vector<std::pair<const char*, std::function<void(Scene&)>>> changes{
        {"linear from far", [](Scene& scene) { scene.depth.near_is_high = false; }},
        {"along the camera's axis", [](Scene& scene) { scene.depth.semantics = DepthSemantics::planar; }},
        {"holes", [](Scene& scene) { scene.depth.invalid_code_count = 1; }},
        {"below the high 8",
         [](Scene& scene) {
             scene.depth_bits = 9;
             scene.depth.code_max = 511;
         }},
        {"white of depth", [](Scene& scene) { scene.depth.code_max = 254; }},
        {"as it has no haptic picture", [](Scene& scene) { scene.default_properties.stiffness = 601; }},
        {"has no haptic picture", [](Scene& scene) { scene.default_properties.static_friction = 0.5; }},
        {"has no haptic picture", [](Scene& scene) { scene.default_properties.dynamic_friction = 0.1; }},
        {"below the high 8", [](Scene& scene) { scene.height_coding.code_max = 1023; }},
        {"not millimetres", [](Scene& scene) { scene.metres_per_unit = 1; }},
        {"not square", [](Scene& scene) { scene.camera.fy = 51; }},
        {"times of their own",
         [](Scene& scene) {
             scene.rate = *rate_of_own_times({0, 5'000'000, 9'000'000});
         }},
        {"a lens", [](Scene& scene) { scene.lens.terms[0] = 0.1; }},
        {"a camera of colour", [](Scene& scene) { scene.colour_camera.emplace(); }},
        {"until the next one", [](Scene& scene) { scene.interpolation = FrameInterpolation::hold; }},
        {"the workspace", [](Scene& scene) { scene.device_metres_per_unit = 0.002; }},
        {"filters", [](Scene& scene) { scene.filter.median = 3; }},
        {"stiffness of holes", [](Scene& scene) { scene.hole_stiffness = 1; }}};
    for (const auto& [said, change] : changes) {
        Scene scene = papers_clip();
        change(scene);
        const auto unsaid = unsaid_by_nodes(scene);
        ASSERT_EQ(unsaid.size(), 1U) << said;
        EXPECT_NE(unsaid[0].find(said), std::string::npos) << unsaid[0];
    }
}

/// What is felt of a haptic picture is in its colours, and pictures may have 16 bits.
TEST(ClipScene, OfPicturesTheirOwnBitsAreSaid) {
    using enum Textures;
    Scene scene = papers_clip();
    scene.default_properties.stiffness = 1;
    EXPECT_EQ(unsaid_by_nodes(scene, {.haptic = false}, pictures).size(), 1U);
    EXPECT_TRUE(unsaid_by_nodes(scene, {.haptic = true}, pictures).empty());
    for (const auto& [bits, code_max, are_all] :
         {std::tuple{8, 255, true}, {8, 254, false}, {12, 4095, false}, {16, 65535, true}}) {
        scene.depth_bits = bits;
        scene.depth.code_max = static_cast<std::uint16_t>(code_max);
        EXPECT_EQ(unsaid_by_nodes(scene, {.haptic = true}, pictures).empty(), are_all) << bits;
    }
    scene.height_coding.code_max = 65535;
    EXPECT_EQ(unsaid_by_nodes(scene, {.haptic = true}, pictures),
              std::vector<std::string>{"height of more than 8 bits"});
}

SceneDescription pictures_of(Scene scene) {
    scene.folder = FolderSource{.depth = "d.png", .colour = "c.png", .haptic = "", .height = "h.png"};
    SceneDescription described(std::move(scene));
    described.unstated.filters = all_unstated;
    return described;
}

TEST(ClipScene, NodesOfPicturesHaveASceneFileOnlyWhereTheyCannotSayAll) {
    const ClipNodes plain = nodes_of_pictures(pictures_of(papers_clip()));
    EXPECT_EQ(plain.scene_file, "");
    EXPECT_EQ(plain.depth, (ClipNodes::Texture{{.file = "d.png"}, false}));
    EXPECT_EQ(plain.colour, (ClipNodes::Texture{{.file = "c.png"}, false}));
    EXPECT_FALSE(plain.haptic);
    EXPECT_EQ(plain.height, (ClipNodes::Texture{{.file = "h.png"}, false}));
    const std::vector<std::function<void(SceneDescription&)>> changes{
        [](SceneDescription& clip) { clip.scene.camera.fx = clip.scene.camera.fy = 50.0 + 1e-12; },
        [](SceneDescription& clip) { clip.scene.depth.near += 1e-13; },
        [](SceneDescription& clip) { clip.unstated.filters.median = false; },
        [](SceneDescription& clip) { clip.scene.remarks.push_back({"guessed: all of it"}); },
        [](SceneDescription& clip) {
            clip.scene.name = "\"quoted\\\n";
            clip.scene.depth.near_is_high = false;
        }};
    for (const auto& change : changes) {
        SceneDescription clip = pictures_of(papers_clip());
        change(clip);
        const ClipNodes nodes = nodes_of_pictures(clip);
        clip.scene.folder.reset();
        clip.scene.rate = {};
        clip.unstated.rate = true;
        EXPECT_EQ(nodes.scene_file + "\n", scene_to_json(clip));
        // By text and by bytes it stays the same.
        const SceneTree tree = scene_of(nodes, 64, 48);
        const auto read = clip_nodes_of(scene_from(scene_text(tree)));
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ(read->scene_file, nodes.scene_file);
        const BifsConfig config = config_for(tree, 64, 48);
        const auto bytes = encode_scene(tree, config);
        ASSERT_TRUE(bytes) << bytes.error().message;
        const auto decoded = decode_scene(*bytes, config);
        ASSERT_TRUE(decoded) << decoded.error().message;
        EXPECT_EQ(clip_nodes_of(*decoded)->scene_file, nodes.scene_file);
    }
}

TEST(ClipScene, AWorldInfoOfOthersSaysNothing) {
    for (const char* world :
         {R"(WorldInfo { title "T3D_SCENE" })", R"(WorldInfo { title "mine" info ["{}"] })"}) {
        const auto nodes = clip_nodes_of(
            scene_from("Group { children [ " + std::string(world) +
                       R"( Shape { geometry Depth { texture ImageTexture { url "d.png" } } } ] })"));
        ASSERT_TRUE(nodes) << nodes.error().message;
        EXPECT_EQ(nodes->scene_file, "");
    }
}

TEST(ClipScene, NodesDescribeTheClipThatTheyCameFrom) {
    const Scene scene = papers_clip();
    const auto described = described_by(mpeg4::nodes_from(scene), 64, 48, 8);
    ASSERT_TRUE(described) << described.error().message;
    EXPECT_EQ(described->scene.depth.near, 10);
    EXPECT_EQ(described->scene.depth.far, 200);
    EXPECT_EQ(described->scene.height_coding.max_height, 2);
    EXPECT_NEAR(described->scene.camera.fx, 50, 1e-12);
    EXPECT_EQ(described->scene.camera.cy, scene.camera.cy);
    Scene same = scene;
    const auto taken = take_nodes(mpeg4::nodes_from(scene), same);
    ASSERT_TRUE(taken);
    EXPECT_FALSE(*taken);
}

/// A DepthImage has angles instead of a focal length: half the picture under half of the angle. It says
/// nothing of touch.
TEST(ClipScene, ADepthImageOverAnotherCameraStands) {
    Scene scene = papers_clip();
    ClipNodes nodes = mpeg4::nodes_from(scene);
    nodes.focal_length = nodes.pixel_width = 0;
    nodes.ranges = {};
    nodes.max_height = 0;
    nodes.angle_x = 2 * std::atan(32.0 / 80);
    nodes.angle_y = 2 * std::atan(24.0 / 80);
    const auto taken = take_nodes(nodes, scene);
    ASSERT_TRUE(taken) << taken.error().message;
    EXPECT_TRUE(*taken);
    EXPECT_NEAR(scene.camera.fx, 80, 1e-9);
    EXPECT_NEAR(scene.camera.fy, 80, 1e-9);
    EXPECT_EQ(scene.height_coding.max_height, 2);
    EXPECT_EQ(scene.haptic.stiffness.max, 7);
}

/// Height in scene units stays in them.
TEST(ClipScene, AnotherHeightIsTakenInTheScenesUnits) {
    Scene scene = papers_clip();
    scene.height_coding = {3, HeightUnits::world, 255};
    ClipNodes nodes = mpeg4::nodes_from(scene);
    EXPECT_NEAR(nodes.max_height, 3 / (190.0 / 255), 1e-12);
    nodes.max_height *= 2;
    ASSERT_TRUE(take_nodes(nodes, scene));
    EXPECT_EQ(scene.height_coding.units, HeightUnits::world);
    EXPECT_NEAR(scene.height_coding.max_height, 6, 1e-12);
}

}  // namespace
}  // namespace touchable::mpeg4
