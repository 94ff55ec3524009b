// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <functional>

#include "engine/mpeg4/bifs.hpp"
#include "engine/scene/scene.hpp"
#include "tests/mpeg4/example_scenes.hpp"

namespace touchable::mpeg4 {
namespace {

using test::must;

/// A clip that nodes describe completely.
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

TEST(ClipScene, NamesWhatNodesLack) {
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

/// Properties are in the colours of a haptic picture, and pictures may have 16 bits.
TEST(ClipScene, AcceptsBitsOfPictures) {
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

TEST(ClipScene, AddsSceneFileWhereNeeded) {
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
        const auto read = must(clip_nodes_of(scene_from(scene_text(tree))));
        EXPECT_EQ(read.scene_file, nodes.scene_file);
        const BifsConfig config = config_for(tree, 64, 48);
        const auto bytes = must(encode_scene(tree, config));
        const auto decoded = must(decode_scene(bytes, config));
        EXPECT_EQ(clip_nodes_of(decoded)->scene_file, nodes.scene_file);
    }
}

TEST(ClipScene, IgnoresForeignWorldInfo) {
    for (const char* world :
         {R"(WorldInfo { title "T3D_SCENE" })", R"(WorldInfo { title "mine" info ["{}"] })"}) {
        const auto nodes = must(clip_nodes_of(
            scene_from("Group { children [ " + std::string(world) +
                       R"( Shape { geometry Depth { texture ImageTexture { url "d.png" } } } ] })")));
        EXPECT_EQ(nodes.scene_file, "");
    }
}

TEST(ClipScene, NodesDescribeTheirClip) {
    const Scene scene = papers_clip();
    const auto described = must(described_by(mpeg4::nodes_from(scene), 64, 48, 8));
    EXPECT_EQ(described.scene.depth.near, 10);
    EXPECT_EQ(described.scene.depth.far, 200);
    EXPECT_EQ(described.scene.height_coding.max_height, 2);
    EXPECT_NEAR(described.scene.camera.fx, 50, 1e-12);
    EXPECT_EQ(described.scene.camera.cy, scene.camera.cy);
    Scene same = scene;
    const auto taken = take_nodes(mpeg4::nodes_from(scene), same);
    ASSERT_TRUE(taken);
    EXPECT_FALSE(*taken);
}

/// A DepthImage has angles instead of a focal length: half the picture under half of the angle. It says
/// nothing of touch.
TEST(ClipScene, TakesCameraOfDepthImage) {
    Scene scene = papers_clip();
    ClipNodes nodes = mpeg4::nodes_from(scene);
    nodes.focal_length = nodes.pixel_width = 0;
    nodes.ranges = {};
    nodes.max_height = 0;
    nodes.angle_x = 2 * std::atan(32.0 / 80);
    nodes.angle_y = 2 * std::atan(24.0 / 80);
    const auto taken = must(take_nodes(nodes, scene));
    EXPECT_TRUE(taken);
    EXPECT_NEAR(scene.camera.fx, 80, 1e-9);
    EXPECT_NEAR(scene.camera.fy, 80, 1e-9);
    EXPECT_EQ(scene.height_coding.max_height, 2);
    EXPECT_EQ(scene.haptic.stiffness.max, 7);
    const Camera camera = must(described_by(nodes, 64, 48, 8)).scene.camera;
    EXPECT_EQ(camera.cx, 31.5) << "the angles are those of the whole picture";
    EXPECT_EQ(camera.cy, 23.5);
}

/// Whichever number of the nodes was edited, the scene beside them has it then.
TEST(ClipScene, TakesEachChangedNumber) {
    for (std::size_t k = 0; k < 10; ++k) {
        Scene scene = papers_clip();
        ClipNodes nodes = mpeg4::nodes_from(scene);
        auto& [stiffness, still, sliding] = nodes.ranges;
        double* const numbers[] = {&nodes.focal_length, &nodes.near,    &nodes.far, &nodes.max_height,
                                   &stiffness.min,      &stiffness.max, &still.min, &still.max,
                                   &sliding.min,        &sliding.max};
        *numbers[k] += 0.01;
        EXPECT_TRUE(must(take_nodes(nodes, scene))) << k;
        EXPECT_FALSE(must(take_nodes(nodes, scene))) << k << ": is taken";
    }
}

/// Height in scene units stays in them.
TEST(ClipScene, KeepsUnitsOfHeight) {
    Scene scene = papers_clip();
    scene.height_coding = {3, HeightUnits::world, 255};
    ClipNodes nodes = mpeg4::nodes_from(scene);
    EXPECT_NEAR(nodes.max_height, 3 / (190.0 / 255), 1e-12);
    nodes.max_height *= 2;
    ASSERT_TRUE(take_nodes(nodes, scene));
    EXPECT_EQ(scene.height_coding.units, HeightUnits::world);
    EXPECT_NEAR(scene.height_coding.max_height, 6, 1e-12);
}

/// The paper's Fig. 13, as its other figures have it: the braces balanced, and the surface inside Appearance.
constexpr std::string_view papers_scene = R"(Shape {
  appearance Appearance {
    texture ImageTexture { url "color_image.jpg" }
    hapticSurface HapticTextureSurface {
      stiffnessRange 0.1 10
      staticFrictionRange 0.2 0.9
      dynamicFrictionRange 0.2 0.9
      maxHeight 1.0
      hapticTexture ImageTexture { url "haptic_image.jpg" }
      heightTexture ImageTexture { url "height_image.png" }
    }
  }
  geometry Depth {
    focalLength 6.983
    pixelWidth 0.00123
    nearPlane 10
    farPlane 200
    texture ImageTexture { url "depth_image.png" }
  }
})";

ClipNodes nodes_from(std::string_view text) {
    return must(clip_nodes_of(scene_from(text)));
}

std::string layout_refusal(std::string_view text) {
    return message(clip_nodes_of(scene_from(text)));
}

void expect_range(const PropertyRange& range, double min, double max) {
    EXPECT_EQ(range.min, min);
    EXPECT_EQ(range.max, max);
}

TEST(ClipNodes, ReadThePapersScene) {
    const ClipNodes nodes = nodes_from(papers_scene);
    EXPECT_EQ(nodes.focal_length, 6.983);
    EXPECT_EQ(nodes.pixel_width, 0.00123);
    EXPECT_EQ(nodes.near, 10);
    EXPECT_EQ(nodes.far, 200);
    EXPECT_EQ(nodes.max_height, 1);
    expect_range(nodes.ranges.stiffness, 0.1, 10);
    expect_range(nodes.ranges.static_friction, 0.2, 0.9);
    expect_range(nodes.ranges.dynamic_friction, 0.2, 0.9);
    EXPECT_EQ(nodes.depth, (ClipNodes::Texture{{.file = "depth_image.png"}}));
    EXPECT_EQ(nodes.colour, (ClipNodes::Texture{{.file = "color_image.jpg"}}));
    EXPECT_EQ(nodes.haptic, (ClipNodes::Texture{{.file = "haptic_image.jpg"}}));
    EXPECT_EQ(nodes.height, (ClipNodes::Texture{{.file = "height_image.png"}}));
}

TEST(ClipNodes, DefaultToThePapersValues) {
    const ClipNodes nodes = nodes_from(
        "Shape { appearance Appearance { hapticSurface HapticTextureSurface {} } geometry Depth { texture "
        "ImageTexture { url \"d.png\" } } }");
    EXPECT_EQ(nodes.focal_length, 4.7);
    EXPECT_EQ(nodes.pixel_width, 0.0112);
    EXPECT_EQ(nodes.near, 40);
    EXPECT_EQ(nodes.far, 180);
    EXPECT_EQ(nodes.max_height, 1);
    expect_range(nodes.ranges.stiffness, 0.1, 10);
    expect_range(nodes.ranges.static_friction, 0.1, 1);
    EXPECT_FALSE(nodes.colour || nodes.haptic || nodes.height);
}

TEST(ClipNodes, TakeInitialValuesOfPrototype) {
    const ClipNodes nodes = nodes_from(prototype_scene);
    EXPECT_EQ(nodes.depth, (ClipNodes::Texture{{.object = 11}, true}));
    EXPECT_EQ(nodes.height, (ClipNodes::Texture{{.object = 13}, true}));
    expect_range(nodes.ranges.dynamic_friction, 0, 0.4);
    const ClipNodes other = nodes_from(R"(
        PROTO Depth [ exposedField SFFloat focalLength 3 exposedField SFFloat pixelWidth 0.5 exposedField SFFloat nearPlane 7
          exposedField SFFloat farPlane 8 exposedField SFNode texture NULL ] { Rectangle {} }
        Group { children [ Shape { geometry Depth { texture MovieTexture { url 5 } } } ] })");
    EXPECT_EQ(other.focal_length, 3);
    EXPECT_EQ(other.near, 7);
}

TEST(ClipNodes, ReadDepthImage) {
    const ClipNodes nodes = nodes_from(depth_image_scene);
    EXPECT_EQ(nodes.near, 10);
    EXPECT_EQ(nodes.far, 200);
    EXPECT_EQ(nodes.angle_x, 0.9);
    EXPECT_EQ(nodes.angle_y, 0.7);
    EXPECT_EQ(nodes.depth, (ClipNodes::Texture{{.object = 11}, true}));
    EXPECT_EQ(nodes.colour, (ClipNodes::Texture{{.object = 10}, true}));
}

/// As files before version 3 have it.
TEST(ClipNodes, ReadPrototypeOfAppearance) {
    const ClipNodes nodes = nodes_from(still_scene);
    expect_range(nodes.ranges.stiffness, 0.1, 2);
    EXPECT_EQ(nodes.haptic, (ClipNodes::Texture{{.object = 12}}));
    EXPECT_EQ(nodes.colour, (ClipNodes::Texture{{.object = 10}}));
}

/// GPAC's player casts what stands in `appearance` to MPEG-4's node, so nothing else may.
TEST(ClipNodes, WritePlainAppearance) {
    ClipNodes nodes = nodes_from(papers_scene);
    const auto in_shape = [](const SceneTree& scene, const char* field) {
        const auto& shape = std::get<NodePtr>(scene.root->field("children")->values.front());
        const Field* const found = shape->field(field);
        return found ? std::get<NodePtr>(found->values.front()) : NodePtr();
    };
    const SceneTree scene = scene_of(nodes, 64, 48);
    EXPECT_EQ(in_shape(scene, "appearance")->type, "Appearance");
    EXPECT_FALSE(in_shape(scene, "appearance")->field("hapticSurface"));
    EXPECT_TRUE(in_shape(scene, "geometry")->field("hapticSurface"));
    for (const Prototype& prototype : scene.prototypes)
        EXPECT_NE(prototype.body.front()->type, "Appearance") << prototype.name;
    nodes.colour.reset();
    EXPECT_EQ(in_shape(scene_of(nodes, 64, 48), "appearance"), nullptr);
}

/// GPAC's player with OpenGL shows an empty outline of a Shape in a Group.
TEST(ClipNodes, WriteOrderedGroup) {
    EXPECT_EQ(scene_of(nodes_from(papers_scene), 64, 48).root->type, "OrderedGroup");
}

TEST(ClipNodes, ReadOrderedGroup) {
    ClipNodes nodes = nodes_from(prototype_scene);
    nodes.scene_file = "{\n}";
    SceneTree scene = scene_of(nodes, 64, 48);
    for (const char* root : {"OrderedGroup", "Group"}) {
        scene.root->type = root;
        const ClipNodes read = must(clip_nodes_of(scene_from(scene_text(scene))));
        EXPECT_EQ(read.depth, nodes.depth) << root;
        EXPECT_EQ(read.scene_file, nodes.scene_file) << root;
    }
}

TEST(ClipNodes, RejectUnknownNamelessPrototypes) {
    SceneTree scene =
        scene_from("PROTO Proto1 [ field SFFloat field0 1 ] { Rectangle {} } Shape { geometry Proto1 {} }");
    scene.has_names = false;
    const auto nodes = clip_nodes_of(scene);
    ASSERT_FALSE(nodes);
    EXPECT_EQ(nodes.error().message,
              "Shape: its geometry must be a Depth (the scene is encoded without names, so a PROTO is known "
              "by the types of its fields alone; MP4Box -def writes names)");
}

TEST(ClipNodes, WritePrototypesOfThePaper) {
    const ClipNodes nodes = nodes_from(papers_scene);
    const SceneTree scene = scene_of(nodes, 64, 48);
    const std::string text = scene_text(scene);
    EXPECT_NE(text.find("PROTO Depth [\n  exposedField SFFloat focalLength 4.7\n  exposedField SFFloat "
                        "pixelWidth 0.0112\n"
                        "  exposedField SFFloat nearPlane 40\n  exposedField SFFloat farPlane 180\n"),
              std::string::npos)
        << text;
    EXPECT_NE(
        text.find(
            "exposedField SFVec2f stiffnessRange 0.1 10\n  exposedField SFVec2f staticFrictionRange 0.1 1\n"),
        std::string::npos)
        << text;
    const ClipNodes again = nodes_from(text);
    EXPECT_EQ(again.depth, nodes.depth);
    EXPECT_EQ(again.colour, nodes.colour);
    EXPECT_EQ(again.haptic, nodes.haptic);
    EXPECT_EQ(again.height, nodes.height);
    EXPECT_EQ(again.focal_length, nodes.focal_length);
    EXPECT_EQ(again.pixel_width, nodes.pixel_width);
    expect_range(again.ranges.static_friction, 0.2, 0.9);
}

TEST(ClipNodes, RejectOtherLayouts) {
    EXPECT_EQ(layout_refusal("Group {}"), "Group: has no Shape");
    EXPECT_EQ(layout_refusal("Group { children [ Shape {} Shape {} ] }"),
              "Group: has a Shape and a Shape: a touchable clip is one Shape");
    EXPECT_EQ(layout_refusal("OrderedGroup {}"), "OrderedGroup: has no Shape");
    EXPECT_EQ(layout_refusal("OrderedGroup { children [ Group {} ] }"),
              "Group: stands in a group: the root must have the Shape itself");
    EXPECT_EQ(layout_refusal("Shape { geometry Rectangle {} }"), "Shape: its geometry must be a Depth");
    EXPECT_EQ(layout_refusal(
                  "PROTO Depth [ field SFFloat focalLength 1 field SFFloat pixelWidth 1 field SFFloat "
                  "nearPlane 1 field SFFloat farPlane 2 field SFNode texture NULL field SFNode "
                  "hapticSurface NULL ] { Rectangle {} } "
                  "Shape { appearance Appearance { hapticSurface HapticTextureSurface {} } geometry "
                  "Depth { texture ImageTexture { url \"d\" } hapticSurface HapticTextureSurface {} } }"),
              "Shape: has a hapticSurface in its geometry and in its appearance: must be one");
    EXPECT_EQ(layout_refusal("Shape { geometry Depth {} }"),
              "Depth: must have a texture, which is its pictures");
    EXPECT_EQ(layout_refusal("Shape { geometry Depth { texture ImageTexture { url [\"a\" \"b\"] } } }"),
              "Depth: texture has 2 urls: must be one");
    EXPECT_EQ(layout_refusal("Shape { geometry Depth { texture WorldInfo {} } }"),
              "Depth: texture is a WorldInfo: must be an ImageTexture or a MovieTexture");
    EXPECT_EQ(layout_refusal(
                  "PROTO Depth [ field SFFloat focalLength 1 ] { Rectangle {} } Shape { geometry Depth {} }"),
              "Depth: must have a field pixelWidth of the paper's type");
    EXPECT_EQ(layout_refusal(
                  "PROTO Group [ field MFFloat children [1 2] ] { WorldInfo {} } Group {  children [1] }"),
              "Group: is a PROTO whose children are no nodes");
    EXPECT_EQ(layout_refusal("PROTO ImageTexture [ field SFBool url TRUE ] { WorldInfo {} } "
                             "Shape { geometry Depth { texture ImageTexture { url FALSE } } }"),
              "Depth: texture is a PROTO whose url is none");
    EXPECT_EQ(layout_refusal("DepthImage { diTexture SimpleTexture { depth ImageTexture { url \"d\" } } }"),
              "DepthImage: is orthographic: must have a perspective camera (orthographic FALSE)");
}

std::string refusal(std::string_view text) {
    return message(parse_scene_text(text));
}

void expect_refusal(std::string_view text, const std::string& words) {
    EXPECT_NE(refusal(text).find(words), std::string::npos) << refusal(text);
}

TEST(SceneText, RoundTrips) {
    for (const std::string_view text :
         {prototype_scene, depth_image_scene, std::string_view(still_scene), depth_image_still_scene}) {
        const std::string once = scene_text(scene_from(text));
        EXPECT_EQ(scene_text(scene_from(once)), once);
    }
}

TEST(SceneText, WritesNodesByLine) {
    EXPECT_EQ(scene_text(scene_from("Group{children[DEF a Shape{} , USE a]}# a comment")),
              "Group {\n  children [\n    DEF a Shape {}\n    USE a\n  ]\n}\n");
    EXPECT_EQ(scene_text(scene_from("MovieTexture { url \"od:12\" loop true startTime 0.1 }")),
              "MovieTexture {\n  loop TRUE\n  startTime 0.1\n  url [12]\n}\n");
    EXPECT_EQ(scene_text(scene_from("MovieTexture { startTime 1e200 }")),
              "MovieTexture {\n  startTime 1e+200\n}\n");
    constexpr std::string_view largest = "Rectangle {\n  size 3.4028235e+38 1e-45\n}\n";
    EXPECT_EQ(scene_text(scene_from(largest)), largest);
}

TEST(SceneText, NamesLineAndColumn) {
    EXPECT_EQ(refusal("Shape {\n  hapticSurface HapticTextureSurface {} }"),
              "line 2, column 3: Shape: has no field \"hapticSurface\"")
        << "as the paper's Fig. 13 is printed";
    EXPECT_EQ(refusal("Group {\n  childern []\n}"),
              "line 2, column 3: Group: has no field \"childern\"; did you mean children?");
    EXPECT_EQ(refusal("Group { children [\n Sphere {} ] }"),
              "line 2, column 2: \"Sphere\" is no node that a touchable clip has");
    EXPECT_EQ(refusal("Group {"), "line 1, column 8: Group: the text ends: must be a field's name or }");
    EXPECT_EQ(refusal("Group { } }"),
              "line 1, column 11: the scene is over, but \"}\" follows: there are more closing braces than "
              "opening ones");
    EXPECT_EQ(refusal("Rectangle { size 1 x }"), "line 1, column 20: found \"x\": must be a number");
    EXPECT_EQ(refusal("Rectangle { size 1 1e99 }"), "line 1, column 20: found \"1e99\": must be a number");
    EXPECT_EQ(refusal("ImageTexture { url [1024] }"),
              "line 1, column 21: found \"1024\": must be a file in quotes, or the number of an object "
              "descriptor, 1 to 1023");
    EXPECT_EQ(refusal("WorldInfo { title \"abc }"), "line 1, column 19: this string has no end");
    EXPECT_EQ(refusal("Group { children USE a }"),
              "line 1, column 22: USE: there is no node \"a\" before it");
    EXPECT_EQ(refusal(""), "line 1, column 1: a node: the text ends: must be a name");
}

TEST(SceneText, RejectsInvalidNamesAndNumbers) {
    const std::string long_name(257, 'a');
    expect_refusal("Group { children DEF " + long_name + " Group {} }", "must be a name of 1 to 256 letters");
    expect_refusal("Group { children DEF NULL Group {} }", "\"NULL\": must be a name");
    expect_refusal("Group { children DEF \xc3\xa9 Group {} }", "must be a name");
    EXPECT_EQ(refusal("PROTO P [ field SFBool a TRUE field SFBool a TRUE ] { Group {} } P {}"),
              "line 1, column 31: PROTO P: has a twice");
    EXPECT_EQ(refusal("PROTO P [ field SFInt32 a 99999999999 ] { Group {} } P {}"),
              "line 1, column 27: found \"99999999999\": must be a whole number");
}

/// A node that is used again counts where it is used: nodes made of each other would stand deeper than any in
/// the text.
TEST(SceneText, BoundsDepthOfUsedNodes) {
    std::string text = "Group { children [ DEF n0 Group {}";
    for (int k = 1; k < 20; ++k)
        text += " DEF n" + std::to_string(k) + " Group { children USE n" + std::to_string(k - 1) + " }";
    EXPECT_EQ(refusal(text + " ] }"), "");
    for (int k = 20; k < 4000; ++k)
        text += " DEF n" + std::to_string(k) + " Group { children USE n" + std::to_string(k - 1) + " }";
    expect_refusal(text + " ] }", "more than 32 deep");
}

TEST(SceneText, RejectsBehaviour) {
    EXPECT_EQ(
        refusal("Group { children [ Script {} ] }"),
        "line 1, column 20: \"Script\" is no node that a touchable clip has: its scene has no behaviour");
    EXPECT_EQ(refusal("Group { children [ QuantizationParameter {} ] }"),
              "line 1, column 20: \"QuantizationParameter\" is no node that a touchable clip has");
    EXPECT_EQ(refusal("Group { }\nROUTE a.b TO c.d"),
              "line 2, column 1: the scene is over, but \"ROUTE\" follows");
}

/// A scene of 64 KiB could have thousands, and every use of one would look through them.
TEST(SceneText, BoundsPrototypesAndFields) {
    std::string fields, many;
    for (int k = 0; k < 65; ++k) {
        fields += " field SFBool f" + std::to_string(k) + " TRUE";
        many += "PROTO P" + std::to_string(k) + " [] { WorldInfo {} }\n";
    }
    expect_refusal("PROTO P [" + fields + "] { WorldInfo {} } Group {}", "has more than 64 fields");
    expect_refusal(many + "Group {}", "more than 64 prototypes");
}

}  // namespace
}  // namespace touchable::mpeg4
