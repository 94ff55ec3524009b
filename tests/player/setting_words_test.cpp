// How the program names the settings that the rooms below it speak of.
#include "player/commands/setting_words.hpp"

#include <gtest/gtest.h>

namespace touchable::test {
namespace {

TEST(SettingWords, AnOptionStandsInForItsNameOrFollows) {
    const std::pair<Error, const char*> cases[] = {
        {usage_error("a.mkv: is empty"), "a.mkv: is empty"},
        {usage_error("damping must be 0 to 100 N s/m", {{Setting::damping}}),
         "--damping must be 0 to 100 N s/m"},
        {usage_error("a.png: damping must be 0 to 100 N s/m", {{Setting::damping}}),
         "a.png: damping must be 0 to 100 N s/m (--damping)"},
        {usage_error("dampings differ", {{Setting::damping}}), "dampings differ (--damping)"},
        {usage_error("CLIP is gone", {{Setting::clip}}), "CLIP is gone (CLIP)"},
        {usage_error("camera needs a live run", {{Setting::camera}, {Setting::live}}),
         "--camera needs a live run (--live)"},
        {usage_error("say how long a stored 1 is", {{Setting::depth_unit, "0.001"}, {Setting::preset}}),
         "say how long a stored 1 is (--depth-unit 0.001, --preset)"}};
    for (const auto& [error, words] : cases) EXPECT_EQ(message_with_options(error), words);
    const Error at_place = error_at("a.mkv", input_error("is empty", {{Setting::scene_file, "FILE"}}));
    EXPECT_EQ(at_place.kind, ErrorKind::input);
    EXPECT_EQ(message_with_options(at_place), "a.mkv: is empty (--scene FILE)");
    const auto knows_none = [](const std::string&) { return false; };
    EXPECT_EQ(message_with_options(at_place, knows_none), "a.mkv: is empty") << "a command without --scene";
    EXPECT_EQ(message_with_options(usage_error("CLIP is gone", {{Setting::clip}}), knows_none),
              "CLIP is gone (CLIP)");
    const Error in_brackets = usage_error("none (there are 2)", {{Setting::scene_file, "FILE"}});
    EXPECT_EQ(message_with_options(in_brackets), "none (there are 2; --scene FILE)");
}

TEST(SettingWords, AGuessNamesTheOptionsThatSayOtherwise) {
    const std::pair<Remark, const char*> cases[] = {
        {{"wide", true, "", {{Setting::field_of_view}, {Setting::intrinsics}}},
         "guessed: wide (--fov DEGREES or --intrinsics FX,FY,CX,CY says otherwise)"},
        {{"a code is 1 mm", true, "0.0001 m of a D405", {{Setting::depth_unit}}},
         "guessed: a code is 1 mm (0.0001 m of a D405: --depth-unit METRES)"},
        {{"wide", true, "a scene file's camera says otherwise"},
         "guessed: wide (a scene file's camera says otherwise)"},
        {{"wide", true}, "guessed: wide (--scene FILE says otherwise)"},
        {{"as camera.json says", false, "", {{Setting::intrinsics}}},
         "as camera.json says (--intrinsics FX,FY,CX,CY says otherwise)"},
        {{"recorded by hand"}, "recorded by hand"}};
    for (const auto& [remark, words] : cases) EXPECT_EQ(remark_with_options(remark), words);
    EXPECT_EQ(remark_in_words(cases[0].first), "guessed: wide (a scene file says otherwise)");
    EXPECT_EQ(remark_text(cases[0].first), "guessed: wide") << "as a scene file keeps it";
}

TEST(SettingWords, OptionsFollowACommandAsTheyAreTyped) {
    EXPECT_EQ(typed_options({{Setting::intrinsics, "525,525"}, {Setting::headless}}),
              " --intrinsics 525,525 --headless");
    EXPECT_EQ(typed_options({}), "");
}

}  // namespace
}  // namespace touchable::test
