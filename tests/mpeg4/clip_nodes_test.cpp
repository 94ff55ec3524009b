#include "engine/mpeg4/clip_scene.hpp"

#include <gtest/gtest.h>

#include "tests/mpeg4/example_scenes.hpp"

namespace touchable::mpeg4 {
namespace {

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

/// The same as it is printed.
constexpr std::string_view printed_scene = R"(Shape {
  appearance Appearance {
    texture ImageTexture {
      url "color_image.jpg"
    }
  }
  hapticSurface HapticTextureSurface {
    stiffnessRange 0.1 10
    staticFrictionRange 0.2 0.9
    dynamicFrictionRange 0.2 0.9
    maxHeight 1.0
    hapticTexture ImageTexture {
      url "haptic_image.jpg"
    }
    heightTexture ImageTexture {
      url "height_image.png"
    }
  }
}
}
}
geometry Depth {
  focalLength 6.983
  pixelWidth 0.00123
  nearPlane 10
  farPlane 200
  texture ImageTexture {
    url "depth_image.png"
  }
}
}
})";

ClipNodes nodes_from(std::string_view text) {
    auto nodes = clip_nodes_of(scene_from(text));
    EXPECT_TRUE(nodes) << (nodes ? "" : nodes.error().message);
    return nodes ? *nodes : ClipNodes();
}

std::string layout_refusal(std::string_view text) {
    const auto nodes = clip_nodes_of(scene_from(text));
    return nodes ? "no error" : nodes.error().message;
}

void expect_range(const PropertyRange& range, double min, double max) {
    EXPECT_EQ(range.min, min);
    EXPECT_EQ(range.max, max);
}

TEST(ClipNodes, ThePapersSceneIsRead) {
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

TEST(ClipNodes, ThePapersPrintIsRefused) {
    const auto printed = parse_scene_text(printed_scene);
    ASSERT_FALSE(printed);
    EXPECT_EQ(printed.error().message, "line 7, column 3: Shape: has no field \"hapticSurface\"");
}

TEST(ClipNodes, WhatIsLeftOutIsAsThePaperHasIt) {
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

TEST(ClipNodes, APrototypesOwnInitialValuesStand) {
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

TEST(ClipNodes, ADepthImageIsRead) {
    const ClipNodes nodes = nodes_from(depth_image_scene);
    EXPECT_EQ(nodes.near, 10);
    EXPECT_EQ(nodes.far, 200);
    EXPECT_EQ(nodes.angle_x, 0.9);
    EXPECT_EQ(nodes.angle_y, 0.7);
    EXPECT_EQ(nodes.depth, (ClipNodes::Texture{{.object = 11}, true}));
    EXPECT_EQ(nodes.colour, (ClipNodes::Texture{{.object = 10}, true}));
}

/// As files before version 3 have it.
TEST(ClipNodes, ReadsPrototypeOfAppearance) {
    const ClipNodes nodes = nodes_from(still_scene);
    expect_range(nodes.ranges.stiffness, 0.1, 2);
    EXPECT_EQ(nodes.haptic, (ClipNodes::Texture{{.object = 12}}));
    EXPECT_EQ(nodes.colour, (ClipNodes::Texture{{.object = 10}}));
}

/// GPAC's player casts what stands in `appearance` to MPEG-4's node, so nothing else may.
TEST(ClipNodes, WritesPlainAppearance) {
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

TEST(ClipNodes, RefusesUnknownNamelessPrototypes) {
    SceneTree scene =
        scene_from("PROTO Proto1 [ field SFFloat field0 1 ] { Rectangle {} } Shape { geometry Proto1 {} }");
    scene.has_names = false;
    const auto nodes = clip_nodes_of(scene);
    ASSERT_FALSE(nodes);
    EXPECT_EQ(nodes.error().message,
              "Shape: its geometry must be a Depth (the scene is encoded without names, so a PROTO is known "
              "by the types of its fields alone; MP4Box -def writes names)");
}

TEST(ClipNodes, AreWrittenByPrototypesWithThePapersInitialValues) {
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

TEST(ClipNodes, AnotherLayoutIsRefusedByName) {
    EXPECT_EQ(layout_refusal("Group {}"), "Group: has no Shape");
    EXPECT_EQ(layout_refusal("Group { children [ Shape {} Shape {} ] }"),
              "Group: has a Shape and a Shape: a touchable clip is one Shape");
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

}  // namespace
}  // namespace touchable::mpeg4
