// Somebody who never read anything, with a mouse and no keys: presses, turns, finds the help, measures, goes
// to the next clip; in windows small and large. Without a window, by the program as a person starts it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "engine/picture/image_file.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

/// Stills of a globe, and of bumps that are a metre away and fill the picture.
const std::filesystem::path& two_stills() {
    static const TemporaryFolder folder;
    static const std::filesystem::path made = [] {
        for (const char* scene : {"globe", "bumps"}) {
            const auto done = run_touchable({"make", scene, (folder / (scene + std::string(".mkv"))).string(),
                                             "--size", "160x120", "--frames", "1"});
            EXPECT_EQ(done.code, 0) << done.err;
        }
        return folder.path();
    }();
    return made;
}

struct WindowOfSize {
    int width, height;
    std::string size() const { return std::to_string(width) + "x" + std::to_string(height); }
};

class MouseAlone : public ::testing::TestWithParam<WindowOfSize> {
protected:
    struct Seen {
        Image image;
        std::string out, kept;
    };
    /// What there is in the end, 3 s after the window opened.
    Seen seen_after(const std::string& script) {
        const TemporaryFolder folder;
        std::ofstream(folder / "script") << script;
        const auto played = run_in_folder(
            {"play", (two_stills() / "globe.mkv").string(), (two_stills() / "bumps.mkv").string(),
             "--headless", "--size", GetParam().size(), "--script", "script", "--settings", "kept.json",
             "--screenshot", "end.png", "--at", "3"},
            folder.path());
        EXPECT_EQ(played.code, 0) << played.err;
        auto image = read_image(folder / "end.png");
        EXPECT_TRUE(image.ok());
        return {image.ok() ? std::move(*image) : Image{}, played.out, file_contents(folder / "kept.json")};
    }
    /// A click `right` pixels from the window's right side (below 0: that many from its left one), on the
    /// bar.
    static std::string click_bar(const std::string& at_s, int right) {
        const int x = right < 0 ? -right : GetParam().width - right;
        return at_s + " move " + std::to_string(x) + " " + std::to_string(GetParam().height - 36) + "\n" +
               at_s + " press left\n" + at_s + " release left\n";
    }
    /// Of the picture, in thousandths of its sides.
    static std::string at(const std::string& word, int x, int y) {
        return word + " " + std::to_string(GetParam().width * x / 1000) + " " +
               std::to_string(GetParam().height * y / 1000) + "\n";
    }
    /// Shares of a part of the pictures, in thousandths of their sides, that differ.
    static double differs(const Image& a, const Image& b, int x0, int y0, int x1, int y1) {
        if (a.width != b.width || a.height != b.height || a.width < 1) return -1;
        int count = 0, all = 0;
        for (int y = a.height * y0 / 1000; y < a.height * y1 / 1000; ++y)
            for (int x = a.width * x0 / 1000; x < a.width * x1 / 1000; ++x) {
                ++all;
                for (int c = 0; c < 3; ++c) {
                    const auto k = static_cast<std::size_t>((y * a.width + x) * 3 + c);
                    if (std::abs(a.samples[k] - b.samples[k]) <= 24) continue;
                    ++count;
                    break;
                }
            }
        return static_cast<double>(count) / all;
    }
    static double middle_differs(const Image& a, const Image& b) { return differs(a, b, 300, 300, 700, 700); }
    const Image& untouched() {
        static std::map<int, Image> known;
        const auto found = known.find(GetParam().width);
        if (found != known.end()) return found->second;
        return known[GetParam().width] = seen_after("").image;
    }
    /// Where a button is in the bar, from its right end.
    static constexpr int help = 39, settings = 84, measure = 170, turn = 250;
    static constexpr int next = -115;  // behind previous and play
};

TEST_P(MouseAlone, FindsTheHelp) {
    EXPECT_GT(middle_differs(seen_after(click_bar("1", help)).image, untouched()), 0.2);
    EXPECT_LT(middle_differs(seen_after(click_bar("1", help) + click_bar("1.5", help)).image, untouched()),
              0.02);
}

TEST_P(MouseAlone, IsElsewhereRightAfterAClick) {
    const std::string away = at("1 move", 500, 500);
    EXPECT_GT(middle_differs(seen_after(click_bar("1", help) + away).image, untouched()), 0.2);
}

TEST_P(MouseAlone, TurnsAndThenPressesAgain) {
    const std::string drag = at("1.2 move", 400, 450) + "1.3 press left\n" + at("1.6 move", 520, 450) +
                             "1.8 release left\n" + "2 leave\n";
    EXPECT_LT(middle_differs(seen_after(drag).image, untouched()), 0.02) << "a drag presses";
    EXPECT_GT(middle_differs(seen_after(click_bar("1", turn) + drag).image, untouched()), 0.05);
    EXPECT_LT(
        middle_differs(seen_after(click_bar("0.8", turn) + click_bar("1", turn) + drag).image, untouched()),
        0.02);
}

TEST_P(MouseAlone, MeasuresADistance) {
    const std::string two = at("1.4 move", 420, 400) + "1.5 press left\n1.6 release left\n" +
                            at("1.8 move", 560, 520) + "1.9 press left\n2 release left\n";
    EXPECT_EQ(seen_after(two).out.find("measured"), std::string::npos);
    EXPECT_NE(seen_after(click_bar("1", measure) + two).out.find("measured"), std::string::npos);
}

TEST_P(MouseAlone, FindsTheSettingsAndTheNextClip) {
    EXPECT_NE(seen_after("").kept.find("\"panel\": false"), std::string::npos);
    EXPECT_NE(seen_after(click_bar("1", settings)).kept.find("\"panel\": true"), std::string::npos);
    const Image clicked = seen_after(click_bar("1", next) + "1.2 leave\n").image;
    EXPECT_GT(middle_differs(clicked, untouched()), 0.3);
    EXPECT_LT(middle_differs(clicked, seen_after("1 next\n").image), 0.02);
}

TEST_P(MouseAlone, ReadsWhatAButtonDoes) {
    const auto over = [&](int right) {
        return seen_after("1 move " + std::to_string(GetParam().width - right) + " " +
                          std::to_string(GetParam().height - 36) + "\n")
            .image;
    };
    const auto words = [&](const Image& a, const Image& b) {  // just above the bar, on its right
        const int above = 1000 - 1000 * 90 / GetParam().height, bar = 1000 - 1000 * 62 / GetParam().height;
        return differs(a, b, 1000 - 1000 * 220 / GetParam().width, above, 1000, bar);
    };
    const Image on_measure = over(measure), on_settings = over(settings);
    EXPECT_GT(words(on_measure, untouched()), 0.1);
    EXPECT_GT(words(on_measure, on_settings), 0.02) << "each has words of its own";
}

INSTANTIATE_TEST_SUITE_P(Sizes, MouseAlone,
                         ::testing::Values(WindowOfSize{640, 400}, WindowOfSize{1280, 720},
                                           WindowOfSize{2560, 1440}),
                         [](const auto& named) { return "Wide" + std::to_string(named.param.width); });

/// A narrow window keeps what is needed most, and a bar to drag.
TEST(MouseAloneInANarrowWindow, LosesColoursBeforeHelp) {
    const TemporaryFolder folder;
    const auto shown = [&](int width, const std::string& script) {
        std::ofstream(folder / "script") << script;
        const auto played = run_in_folder({"play", (two_stills() / "globe.mkv").string(), "--headless",
                                           "--size", std::to_string(width) + "x240", "--script", "script",
                                           "--screenshot", "end.png", "--at", "1.5", "--overwrite"},
                                          folder.path());
        EXPECT_EQ(played.code, 0) << played.err;
        auto image = read_image(folder / "end.png");
        return image.ok() ? std::move(*image) : Image{};
    };
    for (const int width : {240, 320, 480}) {
        const std::string where = std::to_string(width - 39) + " 204\n";
        const Image open = shown(width, "0.5 move " + where + "0.6 press left\n0.7 release left\n"),
                    closed = shown(width, "0.5 move " + where);
        int other = 0;
        for (std::size_t k = 0; k < std::min(open.samples.size(), closed.samples.size()); ++k)
            other += std::abs(open.samples[k] - closed.samples[k]) > 24;
        EXPECT_GT(other, 3000) << width;
    }
}

}  // namespace
}  // namespace touchable::test
