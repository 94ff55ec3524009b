#include "engine/mpeg4/clip_scene.hpp"

#include <gtest/gtest.h>

#include "tests/mpeg4/example_scenes.hpp"

namespace touchable::mpeg4 {
namespace {

std::string refusal(std::string_view text) {
    const auto scene = parse_scene_text(text);
    return scene ? "no error" : scene.error().message;
}

TEST(SceneText, IsReadAsItIsWritten) {
    for (const std::string_view text :
         {prototype_scene, depth_image_scene, std::string_view(still_scene), depth_image_still_scene}) {
        const std::string once = scene_text(scene_from(text));
        EXPECT_EQ(scene_text(scene_from(once)), once);
    }
}

TEST(SceneText, NodesAndFieldsAreWrittenByLine) {
    EXPECT_EQ(scene_text(scene_from("Group{children[DEF a Shape{} , USE a]}# a comment")),
              "Group {\n  children [\n    DEF a Shape {}\n    USE a\n  ]\n}\n");
    EXPECT_EQ(scene_text(scene_from("MovieTexture { url \"od:12\" loop true startTime 0.1 }")),
              "MovieTexture {\n  loop TRUE\n  startTime 0.1\n  url [12]\n}\n");
    EXPECT_EQ(scene_text(scene_from("MovieTexture { startTime 1e200 }")),
              "MovieTexture {\n  startTime 1e+200\n}\n");
    constexpr std::string_view largest = "Rectangle {\n  size 3.4028235e+38 1e-45\n}\n";
    EXPECT_EQ(scene_text(scene_from(largest)), largest);
}

TEST(SceneText, ErrorsNameLineAndColumn) {
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

TEST(SceneText, WhatCannotBeANameOrANumberIsRefused) {
    const std::string long_name(257, 'a');
    EXPECT_NE(refusal("Group { children DEF " + long_name + " Group {} }")
                  .find("must be a name of 1 to 256 letters"),
              std::string::npos);
    EXPECT_NE(refusal("Group { children DEF NULL Group {} }").find("\"NULL\": must be a name"),
              std::string::npos);
    EXPECT_NE(refusal("Group { children DEF \xc3\xa9 Group {} }").find("must be a name"), std::string::npos);
    EXPECT_EQ(refusal("PROTO P [ field SFBool a TRUE field SFBool a TRUE ] { Group {} } P {}"),
              "line 1, column 31: PROTO P: has a twice");
    EXPECT_EQ(refusal("PROTO P [ field SFInt32 a 99999999999 ] { Group {} } P {}"),
              "line 1, column 27: found \"99999999999\": must be a whole number");
}

/// What is used again counts where it is used: nodes made of each other would stand deeper than any in the
/// text.
TEST(SceneText, NodesThatAreUsedAgainStandNoDeeper) {
    std::string text = "Group { children [ DEF n0 Group {}";
    for (int k = 1; k < 20; ++k)
        text += " DEF n" + std::to_string(k) + " Group { children USE n" + std::to_string(k - 1) + " }";
    EXPECT_EQ(refusal(text + " ] }"), "no error");
    for (int k = 20; k < 4000; ++k)
        text += " DEF n" + std::to_string(k) + " Group { children USE n" + std::to_string(k - 1) + " }";
    EXPECT_NE(refusal(text + " ] }").find("more than 32 deep"), std::string::npos);
}

TEST(SceneText, BehaviourIsRefusedByName) {
    EXPECT_EQ(
        refusal("Group { children [ Script {} ] }"),
        "line 1, column 20: \"Script\" is no node that a touchable clip has: its scene has no behaviour");
    EXPECT_EQ(refusal("Group { children [ QuantizationParameter {} ] }"),
              "line 1, column 20: \"QuantizationParameter\" is no node that a touchable clip has");
    EXPECT_EQ(refusal("Group { }\nROUTE a.b TO c.d"),
              "line 2, column 1: the scene is over, but \"ROUTE\" follows");
}

/// A scene of 64 KiB could have thousands, and every use of one would look through them.
TEST(SceneText, PrototypesAndTheirFieldsAreFew) {
    std::string fields, many;
    for (int k = 0; k < 65; ++k) {
        fields += " field SFBool f" + std::to_string(k) + " TRUE";
        many += "PROTO P" + std::to_string(k) + " [] { WorldInfo {} }\n";
    }
    EXPECT_NE(refusal("PROTO P [" + fields + "] { WorldInfo {} } Group {}").find("has more than 64 fields"),
              std::string::npos);
    EXPECT_NE(refusal(many + "Group {}").find("more than 64 prototypes"), std::string::npos);
}

}  // namespace
}  // namespace touchable::mpeg4
