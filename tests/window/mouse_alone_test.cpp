// Somebody who never read anything, with a mouse and no keys: finds the help, reads what buttons do, presses,
// turns, measures, goes to the next clip and back; in windows small and large. Without a window, by the
// program as a person starts it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

struct WindowOfSize {
    int width, height;
};

/// Of words and bars: sqrt(2), to the next quarter, where the window has twice as much room.
double scale_of(const WindowOfSize& window) {
    return window.width > 2000 ? 1.5 : 1;
}

/// What somebody does with a mouse, as a script, and pictures of what is seen then.
class MouseScript {
public:
    explicit MouseScript(const WindowOfSize& window) : window_(window) {}
    /// Large pictures take long to be written: whoever sees so many takes more time.
    double times() const { return window_.width > 2000 ? 3 : 1; }

    /// A place of the picture, in thousandths of its sides.
    void move(double at_s, int x, int y) {
        move_to(at_s, window_.width * x / 1000, window_.height * y / 1000);
    }
    void press(double at_s) { add(at_s, "press left"); }
    void release(double at_s) { add(at_s, "release left"); }
    void leave(double at_s) { add(at_s, "leave"); }
    void picture(double at_s, const std::string& name) { add(at_s, "screenshot " + name); }
    /// On the bar, so many pixels from its right end; below 0: from its left one.
    void move_to_bar(double at_s, int from_end) {
        const int along = scaled(std::abs(from_end));
        move_to(at_s, from_end < 0 ? along : window_.width - along, window_.height - scaled(36));
    }
    void click_bar(double at_s, int from_end) {
        move_to_bar(at_s, from_end);
        press(at_s);
        release(at_s);
    }
    void drag(double at_s) {
        move(at_s, 400, 450);
        press(at_s + 0.05);
        move(at_s + 0.1, 520, 450);
        release(at_s + 0.15);
        leave(at_s + 0.2);
    }
    void turn(double at_s, int degrees) { add(at_s, "turn " + std::to_string(degrees)); }
    void quit(double at_s) { add(at_s, "quit"); }
    const std::string& words() const { return words_; }

private:
    void add(double at_s, const std::string& what) {
        words_ += std::to_string(at_s * times()) + " " + what + "\n";
    }
    int scaled(int pixels) const { return static_cast<int>(scale_of(window_) * pixels); }
    void move_to(double at_s, int x, int y) {
        add(at_s, "move " + std::to_string(x) + " " + std::to_string(y));
    }

    WindowOfSize window_;
    std::string words_;
};

/// Where buttons are.
constexpr int help = 39, settings = 84, measure = 170, turn = 288, previous = -39, next = -115;

class MouseAlone : public ::testing::TestWithParam<WindowOfSize> {
protected:
    void SetUp() override {
        for (const char* scene : {"globe", "bumps"})
            ASSERT_EQ(run_touchable({"make", scene, (folder_ / (scene + std::string(".mkv"))).string(),
                                     "--size", "160x120", "--frames", "1"})
                          .code,
                      0);
    }
    /// What the program says in the end.
    std::string play(const std::vector<std::string>& clips, const std::string& script) {
        const auto [width, height] = GetParam();
        const auto played =
            run_scripted(clips, script, folder_.path(), std::to_string(width) + "x" + std::to_string(height));
        EXPECT_EQ(played.code, 0) << played.err;
        return played.out;
    }
    /// Share of a part of two pictures, in thousandths of their sides, that differs.
    double differs(const std::string& name, const std::string& other, int x0, int y0, int x1, int y1) {
        const auto a = read_image(folder_ / name), b = read_image(folder_ / other);
        EXPECT_TRUE(a && b) << name << ", " << other;
        if (!a || !b) return -1;
        const PicturePart part{a->width * x0 / 1000, a->height * y0 / 1000, a->width * x1 / 1000,
                               a->height * y1 / 1000};
        const double all = (part.x1 - part.x0) * (part.y1 - part.y0);
        return differences(*a, *b, part) / all;
    }
    double middle_differs(const std::string& name, const std::string& other) {
        return differs(name, other, 300, 300, 700, 700);
    }
    /// Of a part whose corners are so far from the picture's right and lower side, in pixels of the words'
    /// scale.
    double lower_right_differs(const std::string& name, const std::string& other, int left, int top,
                               int right, int bottom) {
        const auto [width, height] = GetParam();
        const auto place = [&](int pixels, int side) {
            return 1000 - static_cast<int>(scale_of(GetParam()) * 1000 * pixels / side);
        };
        return differs(name, other, place(left, width), place(top, height), place(right, width),
                       place(bottom, height));
    }
    /// Just above the bar, on its right: where the words of a button are.
    double words_differ(const std::string& name, const std::string& other) {
        return lower_right_differs(name, other, 220, 92, 24, 68);
    }

    const TemporaryFolder folder_;
};

TEST_P(MouseAlone, FindsHelpTurnsAndMeasures) {
    MouseScript script(GetParam());
    script.picture(0.4, "untouched.png");
    script.click_bar(0.5, help);
    script.move(0.5, 500, 500);  // a quick hand is elsewhere in the next picture
    script.picture(0.9, "help.png");
    script.click_bar(1, help);
    script.leave(1.2);
    script.picture(1.3, "closed.png");
    script.move_to_bar(1.4, measure);
    script.picture(1.6, "on-measure.png");
    script.move_to_bar(1.65, settings);
    script.picture(1.85, "on-settings.png");
    script.drag(1.9);
    script.picture(2.3, "pressed.png");
    script.click_bar(2.4, turn);
    script.drag(2.6);
    script.picture(2.9, "turned.png");
    script.click_bar(3, turn);
    script.drag(3.2);
    script.picture(3.5, "pressed-again.png");
    script.click_bar(3.6, measure);
    script.move(3.8, 420, 400);
    script.press(3.85);
    script.release(3.9);
    script.move(4, 560, 520);
    script.press(4.05);
    script.release(4.1);
    script.click_bar(4.3, settings);
    script.picture(4.5, "settings.png");
    script.click_bar(4.6, settings);
    script.quit(5);
    const std::string said = play({"globe.mkv"}, script.words());

    EXPECT_GT(middle_differs("help.png", "untouched.png"), 0.2);
    EXPECT_LT(middle_differs("closed.png", "untouched.png"), 0.02);
    EXPECT_GT(words_differ("on-measure.png", "untouched.png"), 0.1);
    EXPECT_GT(words_differ("on-measure.png", "on-settings.png"), 0.02) << "each has words of its own";
    EXPECT_LT(middle_differs("pressed.png", "untouched.png"), 0.02) << "a drag presses";
    EXPECT_GT(middle_differs("turned.png", "untouched.png"), 0.05);
    EXPECT_LT(middle_differs("pressed-again.png", "turned.png"), 0.02);
    EXPECT_NE(said.find("measured"), std::string::npos) << said;
    const int width = GetParam().width;  // of which the panel has the same pixels on the right
    EXPECT_GT(differs("settings.png", "turned.png", 1000 - 240'000 / width, 100, 1000 - 20'000 / width, 700),
              0.2);
}

TEST_P(MouseAlone, GoesToTheNextClipAndBack) {
    MouseScript script(GetParam());
    script.picture(0.3, "first.png");
    script.click_bar(0.5, next);
    script.leave(0.6);
    script.picture(1.2, "next.png");
    script.click_bar(1.4, previous);
    script.leave(1.5);
    script.picture(2.2, "back.png");
    script.quit(2.3);
    play({"globe.mkv", "bumps.mkv"}, script.words());
    EXPECT_GT(middle_differs("next.png", "first.png"), 0.3);
    EXPECT_LT(middle_differs("back.png", "first.png"), 0.02);
}

/// Above what is said of the button.
TEST_P(MouseAlone, ReadsTheLegendWhileAButtonIsExplained) {
    MouseScript script(GetParam());
    script.leave(0.1);
    script.picture(0.5, "away.png");
    script.move_to_bar(0.6, settings);
    script.picture(1, "explained.png");
    script.quit(1.1);
    play({"globe.mkv"}, "0 overlay depth\n" + script.words());
    EXPECT_GT(lower_right_differs("explained.png", "away.png", 200, 140, 20, 104), 0.2);
}

INSTANTIATE_TEST_SUITE_P(Sizes, MouseAlone,
                         ::testing::Values(WindowOfSize{640, 400}, WindowOfSize{1280, 720},
                                           WindowOfSize{2560, 1440}),
                         [](const auto& named) { return "Wide" + std::to_string(named.param.width); });

/// In a narrow window the bar keeps what is needed most, and the legend of an overlay has a place beside
/// what is said of the pixel under the pointer.
class MouseInANarrowWindow : public MouseAlone {};

TEST_P(MouseInANarrowWindow, FindsHelpAndReadsLegends) {
    MouseScript script(GetParam());
    script.move(0.1, 450, 400);
    const std::string legend = "0.1 overlay depth\n";
    script.picture(0.5, "legend.png");
    script.leave(0.6);
    script.picture(0.9, "away.png");
    script.click_bar(1, help);
    script.picture(1.4, "help.png");
    script.quit(1.5);
    play({"globe.mkv"}, legend + script.words());
    EXPECT_GT(differs("help.png", "away.png", 200, 100, 800, 600), 0.3);
    // The lower right, where the legend is when nothing is said of a pixel.
    const auto [width, height] = GetParam();
    const int top = 1000 - 110'000 / height, bottom = 1000 - 66'000 / height;
    EXPECT_GT(differs("legend.png", "away.png", 1000 - 200'000 / width, top, 1000 - 20'000 / width, bottom),
              0.2);
}

/// They take a fifth of its height, and are not said of what the bar covers, where buttons explain
/// themselves.
TEST_P(MouseInANarrowWindow, ThePixelsWordsLeaveThePictureFree) {
    MouseScript script(GetParam());
    script.move(0.1, 800, 300);
    script.picture(0.5, "said.png");
    script.leave(0.6);
    script.picture(0.9, "away.png");
    script.move_to_bar(1, help);
    script.picture(1.4, "on-help.png");
    script.quit(1.5);
    play({"globe.mkv"}, script.words());
    const auto [width, height] = GetParam();
    const int left = 20'000 / width, right = 110'000 / width, bottom = 1000 - 74'000 / height;
    EXPECT_LT(differs("said.png", "away.png", left, 470, right, 1000 - 148'000 / height), 0.001);
    EXPECT_GT(differs("said.png", "away.png", left, 1000 - 100'000 / height, right, bottom), 0.1);
    EXPECT_LT(differs("on-help.png", "away.png", left, 470, right, bottom), 0.001);
}

/// The house is among what is needed most: whoever has no keys comes back by it.
TEST_P(MouseInANarrowWindow, FindsTheWayBackToTheClipsOwnView) {
    MouseScript script(GetParam());
    script.leave(0.1);
    script.picture(0.5, "own.png");
    script.turn(0.6, 30);
    script.picture(0.9, "turned.png");
    script.click_bar(1, GetParam().width < 400 ? 77 : 158);
    script.leave(1.2);
    script.picture(1.5, "back.png");
    script.quit(1.6);
    play({"globe.mkv"}, script.words());
    EXPECT_GT(middle_differs("turned.png", "own.png"), 0.1);
    EXPECT_LT(middle_differs("back.png", "own.png"), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Narrow, MouseInANarrowWindow,
                         ::testing::Values(WindowOfSize{320, 400}, WindowOfSize{480, 360}),
                         [](const auto& named) { return "Wide" + std::to_string(named.param.width); });

}  // namespace
}  // namespace touchable::test
