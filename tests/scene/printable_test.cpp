#include "engine/base/words.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

TEST(Printable, OrdinaryTextStaysAsItIs) {
    EXPECT_EQ(printable("depth_%04d.png"), "depth_%04d.png");
    EXPECT_EQ(printable("Größe 3 µm"), "Größe 3 µm");
    EXPECT_EQ(printable("\xff\xfe"), "\xff\xfe");  // names of files need not be UTF-8
    EXPECT_EQ(printable(std::string(80, 'x')), std::string(80, 'x'));
    EXPECT_EQ(in_quotes("a"), "\"a\"");
}

TEST(Printable, AFileInACommandIsOneWordOfAShell) {
    EXPECT_EQ(shell_word("clips/my-clip_1.mkv"), "clips/my-clip_1.mkv");
    EXPECT_EQ(shell_word("Größe.json"), "Größe.json");
    EXPECT_EQ(shell_word("-clip.mkv"), "./-clip.mkv");
    EXPECT_EQ(shell_word("my clip.mkv"), "'my clip.mkv'");
    for (const std::string name : {"my clip.mkv", "it's.mkv", "$HOME;`ls` \"x\" *?[a]~#&|<>()!.mkv", "~",
                                   "a\\b", "Büro Köln ä/redwood", "two\nlines's\\.mkv", "\x1b[0m",
                                   "\xc2\x9b"
                                   "5",
                                   ""}) {
        const std::string command = "bash -c " + shell_word("printf %s " + shell_word(name));
        FILE* const pipe = popen(command.c_str(), "r");
        ASSERT_NE(pipe, nullptr);
        char said[200] = {};
        const std::size_t bytes = fread(said, 1, sizeof said, pipe);
        pclose(pipe);
        EXPECT_EQ(std::string(said, bytes), name) << command;
    }
}

TEST(Printable, ControlCharactersAreEscaped) {
    EXPECT_EQ(printable(std::string("a\nb\r\t\0\x1b[0m\x7f", 11)), "a\\nb\\r\\t\\x00\\x1b[0m\\x7f");
    EXPECT_EQ(printable("\xc2\x9b"
                        "31m"),
              "\\xc2\\x9b31m");  // an escape sequence begins so, too
}

TEST(Printable, LongTextIsCutBetweenCharacters) {
    EXPECT_EQ(printable(std::string(3'000'000, 'x')), std::string(80, 'x') + "...");
    EXPECT_EQ(printable("abcdé", 5), "abcd...");
    EXPECT_EQ(printable("abcd\n", 5), "abcd...");
    EXPECT_EQ(printable(std::string("abc\0", 4), 5), "abc...");
}

TEST(Printable, WhateverASceneFileHoldsTheErrorIsShort) {
    const std::string long_text(1'000'000, 'y');
    for (const std::string& text :
         {"{\"" + long_text, "{\"" + long_text + "\": 1}", "[\"\x1b" + long_text, "\"" + long_text + "\"",
          "{\"touchable_scene\": 1, \"name\": 3, \"" + long_text + "\": {}}"}) {
        const auto scene = parse_scene(text, "scene.json");
        ASSERT_FALSE(scene);
        EXPECT_LT(scene.error().message.size(), 500U);
        EXPECT_EQ(scene.error().message.find_first_of("\n\x1b"), std::string::npos);
    }
}

}  // namespace
}  // namespace touchable
