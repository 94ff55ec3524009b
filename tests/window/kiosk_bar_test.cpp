// A kiosk's bar of large buttons: what visitors do by it, with a mouse and with a finger, and what is left of
// it. In a window so narrow that buttons are as wide as there is room for, so that it is known where they
// are.
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "player/window/play_window.hpp"
#include "tests/player/program.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

/// From the left, of two clips that are more than a picture; of one there is no `next`, of pictures no
/// `pause`.
enum class Pressed { mode, pause, colours, next, straight };

/// Where it is, of so many, in a window of 320x240.
std::string place_of(int button, int count) {
    const double wide = (320.0 - 12 - 6 * (count + 1)) / count, left = 6 + 6;
    return std::to_string(static_cast<int>(left + button * (wide + 6) + wide / 2)) + " 198";
}
std::string click(double at_s, const std::string& place) {
    return std::to_string(at_s) + " move " + place + "\n" + std::to_string(at_s + 0.15) + " press left\n" +
           std::to_string(at_s + 0.3) + " release left\n" + std::to_string(at_s + 0.45) + " move 310 4\n";
}
std::string tap(double at_s, const std::string& place) {
    return std::to_string(at_s) + " touch 1 " + place + "\n" + std::to_string(at_s + 0.2) + " touch-end 1\n";
}

constexpr PicturePart above{90, 8, 312, 150}, bar{8, 164, 312, 232};

class KioskBarTest : public ::testing::Test {
protected:
    /// Of two pictures: turn, colours, next, straight.
    static Image seen(const std::string& script, const char* seconds, std::vector<std::string> more = {}) {
        std::vector<std::string> words{made_clip("globe", 1).string(), made_clip("bumps", 1).string(),
                                       "--kiosk"};
        words.insert(words.end(), more.begin(), more.end());
        return played_by(words, script, seconds).image;
    }
    static Image bumps(const std::string& script, const char* seconds) {
        return played_by({made_clip("bumps", 1).string(), "--kiosk"}, script, seconds).image;
    }
    static std::string turn() { return place_of(0, 4); }
    static std::string colours() { return place_of(1, 4); }
    static std::string next() { return place_of(2, 4); }
    static std::string straight() { return place_of(3, 4); }
};

TEST_F(KioskBarTest, TurnsColoursAndLeadsBackByMouseAndByFinger) {
    const Image plain = seen("0 move 310 4\n", "1");
    for (const auto& press : {click, tap}) {
        const Image coloured = seen(press(0.1, colours()), "1.2");
        EXPECT_GT(differences(plain, coloured, above), 3000);
        const std::string drag =
            "0.8 move 200 60\n0.9 press left\n1 move 260 60\n1.1 release left\n1.2 move 310 4\n";
        const Image
            pressed = seen(drag, "1.9"),
            turned = seen(press(0.1, turn()) + drag, "1.9"),
            back = seen(press(0.1, turn()) + drag + press(1.4, straight()), "2.6"),
            again =
                seen(press(0.1, turn()) + drag + press(1.4, straight()) +
                         "2 move 200 60\n2.1 press left\n2.2 move 260 60\n2.3 release left\n2.4 move 310 4\n",
                     "3.1");
        EXPECT_LT(differences(plain, pressed, above), 300) << "a drag touches";
        EXPECT_GT(differences(plain, turned, above), 3000) << "a drag turns";
        EXPECT_LT(differences(plain, back, above), 300);
        EXPECT_LT(differences(plain, again, above), 300) << "whoever is back touches again";
        EXPECT_GT(differences(pressed, turned, bar), 100) << "nobody sees that it turns";
    }
}

TEST_F(KioskBarTest, ColoursAndTurnedViewStayWithAVisitorFromClipToClip) {
    const std::string chosen = "0.1 turn 30\n" + click(0.2, colours());
    const Image other = seen(chosen + click(0.9, next()), "2"),
                same = bumps("0.1 turn 30\n0.2 overlay depth\n0.8 move 310 4\n", "2");
    EXPECT_LT(differences(other, same, above), 100);
    EXPECT_GT(differences(same, bumps("", "1"), above), 3000);
    EXPECT_LT(differences(seen(click(0.2, next()), "1.5"), bumps("0.5 move 310 4\n", "1.5"), above), 100);
}

/// The finger that invites is elsewhere.
TEST_F(KioskBarTest, TheNextVisitorBeginsWithTheFirstClipStraightAndWithItsColours) {
    const std::vector<std::string> soon{"--idle", "0.8", "0.9"};
    constexpr PicturePart beside{100, 30, 150, 90};
    const Image fresh = seen("", "0.5"),
                chosen = seen("0.1 turn 30\n" + click(0.1, colours()) + click(0.6, next()), "1.4",
                              {"--idle", "9", "9"}),
                later = seen("0.1 turn 30\n" + click(0.1, colours()) + click(0.6, next()), "4", soon);
    EXPECT_GT(differences(fresh, chosen, beside), 1500);
    EXPECT_LT(differences(fresh, later, beside), 100);
}

TEST_F(KioskBarTest, AButtonThatIsHeldOverTheResetDoesNothing) {
    const std::vector<std::string> soon{"--idle", "0.8", "0.8"};
    const std::string by_mouse =
                          "0.1 move " + colours() + "\n0.2 press left\n2.6 release left\n2.7 move 310 4\n",
                      by_finger = "0.1 touch 1 " + colours() + "\n3 touch-end 1\n3.1 move 310 4\n";
    const Image fresh = seen("0 move 310 4\n", "0.3");
    EXPECT_LT(differences(fresh, seen(by_mouse, "2.9", soon), above), 100);
    EXPECT_LT(differences(fresh, seen(by_finger, "3.3", soon), above), 100);
}

/// One clip: of several the next one would come.
TEST_F(KioskBarTest, GoesWhereNothingMovesAndMayBeLeftOut) {
    const auto alone = [](const std::string& script, const char* seconds, std::vector<std::string> more) {
        more.insert(more.begin(), {made_clip("globe", 1).string(), "--kiosk"});
        return played_by(more, script, seconds).image;
    };
    const std::vector<std::string> late{"--idle", "30", "60"};
    const Image shown = alone("0.1 move 310 4\n", "1", late), gone = alone("0.1 move 310 4\n", "5", late),
                again = alone("5 move 310 4\n", "5.4", late),
                off = alone("0.1 move 310 4\n", "1", {"--kiosk-bar", "off"});
    EXPECT_GT(differences(shown, gone, bar), 3000);
    EXPECT_LT(differences(shown, again, bar), 100);
    EXPECT_LT(differences(gone, off, bar), 100);
    const auto refused = [](const std::vector<std::string>& more) {
        std::vector<std::string> words{"play", made_clip("globe", 1).string(), "--headless", "--seconds",
                                       "0.2"};
        words.insert(words.end(), more.begin(), more.end());
        const auto outcome = run_touchable(words);
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        return outcome.code;
    };
    EXPECT_EQ(refused({"--kiosk", "--kiosk-bar", "perhaps"}), 2);
    EXPECT_EQ(refused({"--kiosk-bar", "off"}), 2);
}

/// How often a finger comes to the surface.
int touches_by(const std::string& script) {
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << script << "5.4 quit\n";
    PlayOptions options;
    options.session.clip.file = made_clip("bumps", 1);
    options.session.builder.name = "cpu";
    options.headless = true;
    options.painter = "cpu";
    options.screen.width = 320;
    options.screen.height = 240;
    options.kiosk = KioskOptions{};
    options.meter = std::make_shared<TouchMeter>();
    auto inputs = read_window_script(folder / "script");
    EXPECT_TRUE(inputs) << inputs.error().message;
    if (!inputs) return -1;
    options.script = std::move(*inputs);
    const auto played = play_in_window(options);
    EXPECT_TRUE(played) << played.error().message;
    return options.meter->measures().touches;
}

TEST_F(KioskBarTest, APressOnAButtonTouchesNothingAndWhereItIsGoneTheSurfaceIsTouched) {
    const std::string button = place_of(1, 3);
    EXPECT_EQ(touches_by(click(0.5, button) + tap(1.2, button)), 0);
    const std::string deep = "0.3 move " + button + "\n0.4 wheel 9\n0.5 wheel 9\n";
    EXPECT_EQ(touches_by(deep + click(0.6, button)), 0);
    EXPECT_GE(touches_by("0.2 move 160 60\n0.4 press left\n1 release left\n"), 1);
    EXPECT_GE(touches_by("0.1 move 2 2\n4.7 touch 1 " + button + "\n5 touch-end 1\n"), 1);
}

}  // namespace
}  // namespace touchable::test
