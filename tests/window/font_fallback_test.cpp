// Letters of a kiosk's texts that the usual typeface has not: others write them, or whoever set it up is
// told.
#include "player/window/imgui_layer.hpp"

#include <gtest/gtest.h>
#include <imgui.h>

#include <fstream>
#include <string>
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

// Of DejaVu, which every Debian with this program has, Mono alone has the first; the second is no letter yet,
// and letters of mathematics lie beyond 16 bits.
const std::string of_mono = "\u2312", of_nobody = "\u2fe0", beyond = "\U0001d4d0";
const std::string hebrew = "\u05d0\u05d1";

TEST(FontFallback, WhatTheUsualTypefaceHasNotAnotherWrites) {
    const FontFallback latin = find_fonts("Touch the picture, Größe, Ελλάδα");
    ASSERT_TRUE(latin.usual);
    EXPECT_EQ(latin.unwritten, "");
    const FontFallback both = find_fonts("a" + of_mono + "b" + of_mono);
    EXPECT_EQ(both.usual, latin.usual);
    ASSERT_EQ(both.others.size(), 1U);
    EXPECT_EQ(both.others[0].letters, of_mono);
    EXPECT_NE(both.others[0].face, both.usual);
    EXPECT_EQ(both.unwritten, "");
}

TEST(FontFallback, AnotherTypefacesLettersAreDrawnInBothSizes) {
    ImGuiLayer layer(1, "a" + of_mono + of_nobody);
    for (const double scale : {1.0, 2.0}) {
        if (scale > 1) layer.set_scale(scale);
        const auto& fonts = ImGui::GetIO().Fonts->Fonts;
        ASSERT_EQ(fonts.size(), 2);
        EXPECT_LT(fonts[0]->FontSize, fonts[1]->FontSize);
        for (const ImFont* font : fonts) {
            EXPECT_NE(font->FindGlyphNoFallback(0x2312), nullptr);
            EXPECT_EQ(font->FindGlyphNoFallback(0x2fe0), nullptr);
            ASSERT_NE(font->FallbackGlyph, nullptr);
            EXPECT_TRUE(font->FallbackGlyph->Visible) << "a letter that is not there is seen as a sign";
        }
    }
    EXPECT_EQ(layer.unwritten(), of_nobody);
}

TEST(FontFallback, LettersThatNobodyWritesAreNamedOnce) {
    const FontFallback none = find_fonts(of_nobody + "a" + beyond + of_nobody);
    EXPECT_TRUE(none.others.empty());
    EXPECT_EQ(none.unwritten, of_nobody + beyond);
}

TEST(FontFallback, HebrewAndArabicAreWrittenFromRightToLeft) {
    EXPECT_EQ(right_to_left_letters("a" + hebrew + " b\u0627" + hebrew), hebrew + "\u0627");
    EXPECT_EQ(right_to_left_letters("Größe, 日本, Ελλάδα"), "");
}

TEST(FontFallback, WhoeverSetsUpAKioskIsToldWhatVisitorsCannotRead) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", texts = folder / "texts.json";
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--size", "64x48", "--frames", "2"}).code, 0);
    const auto told = [&](const std::string& invitation) {
        std::ofstream(texts) << R"({"touchable_kiosk_texts": 1, "language": "he", "invitation": ")"
                             << invitation << "\"}";
        const Outcome kiosk = run_touchable({"play", clip, "--headless", "--kiosk", "--seconds", "0.2",
                                             "--kiosk-texts", texts, "--painter", "cpu"});
        EXPECT_EQ(kiosk.code, 0) << kiosk.err;
        return kiosk.err;
    };
    EXPECT_EQ(told("Touch " + of_mono), "");
    const std::string box = told("Touch " + of_nobody);
    EXPECT_NE(box.find("no typeface of this machine has these letters of the kiosk's texts"),
              std::string::npos)
        << box;
    const std::string reversed = told(hebrew);
    EXPECT_NE(reversed.find("from left to right, and so these letters of the kiosk's texts too: " + hebrew),
              std::string::npos)
        << reversed;
}

}  // namespace
}  // namespace touchable::test
