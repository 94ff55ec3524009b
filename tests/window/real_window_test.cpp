// SPDX-License-Identifier: Apache-2.0
// A window on a display, with keys and a mouse as a person has them.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>

#include "engine/picture/image.hpp"
#include "player/window/screen.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/window_rig.hpp"

namespace touchable::test {
namespace {

bool has_programs(const std::string& names) {
    return std::system(("command -v " + names + " >/dev/null").c_str()) == 0;
}
bool has_library(const std::string& name) {
    return std::system(("ldconfig -p | grep -q " + name).c_str()) == 0;
}

/// In a folder of its own: a globe of 30 frames, and what the program says, in `out` and `err`.
class RealWindow : public ::testing::Test {
protected:
    void SetUp() override {
        if (has_programs("Xvfb xdotool")) return make_clip(folder / "globe.mkv", "globe", 30, "160x120");
        ASSERT_EQ(std::getenv("TOUCHABLE_REQUIRE_DATA"), nullptr) << "Xvfb and xdotool are not installed";
        GTEST_SKIP() << "Xvfb and xdotool are not installed";
    }
    /// Runs `actions` while the program with `words` has a window on a display of its own, and gives the
    /// program's exit code. `before`: actions before that.
    int run(const std::string& words, const std::string& actions, const std::string& before = "") {
        return run_on_display(folder.path(), R"(
rm -f display  # of a run before
Xvfb -displayfd 3 -screen 0 1024x768x24 -nolisten tcp -noreset 3>display 2>xvfb.log & server=$!
trap 'kill $server 2>/dev/null' EXIT
for k in $(seq 600); do [[ -s display ]] && break; sleep 0.1; done
[[ -s display ]] || exit 99
export DISPLAY=:$(cat display) XDG_CONFIG_HOME=$PWD/config XDG_STATE_HOME=$PWD/state
)" + before,
                              words, actions);
    }
    std::string text(const std::string& file) const { return file_contents(folder / file); }
    std::string kept() const { return text("config/touchable/play.json"); }

    const TemporaryFolder folder;
};

void expect_one_line(const std::string& text, const std::string& part) {
    EXPECT_TRUE(contains(text, part));
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
}

TEST_F(RealWindow, WorksByMouseAndKeys) {
    const int code = run("play globe.mkv --size 640x400 --record hand.touch", R"(
xdotool mousemove 320 180 sleep 0.3 mousedown 1 sleep 0.3 mousemove 340 190 sleep 0.3 key space sleep 0.2 key o sleep 0.2
xdotool key F12 sleep 0.3 mouseup 1 sleep 0.2 windowsize $(head -1 window) 500 360 sleep 0.4 key Tab sleep 0.3 key F12 sleep 0.3 key Escape sleep 0.3 key Escape
)");
    EXPECT_EQ(code, 0) << text("err");
    EXPECT_EQ(text("err"), "");
    EXPECT_TRUE(contains(text("out"), "input to picture"));
    const auto first = read_image(folder / "touchable-1.png"),
               second = read_image(folder / "touchable-2.png");
    ASSERT_TRUE(first) << first.error().message;
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_EQ(first->width, 640);
    EXPECT_EQ(first->height, 400);
    EXPECT_EQ(second->width, 500);
    EXPECT_EQ(second->height, 360);
    EXPECT_TRUE(contains(kept(), "\"panel\": true"));
    replayed(folder.path(), "hand.touch");
}

/// Bash functions: wait until the window has this title, or this size.
constexpr const char* waits = R"(
until_called() { for k in $(seq 600); do [[ $(xdotool getwindowname $(head -1 window)) == "$1 - touchable" ]] && return; sleep 0.1; done; echo "$layout: not $1" >>out; exit 95; }
until_sized() { for k in $(seq 600); do xdotool getwindowgeometry $(head -1 window) | grep -q "$1" && return; sleep 0.1; done; echo "$layout: not $1" >>out; exit 94; }
)";

constexpr const char* all_layouts[] = {"us", "de", "fr", "es", "se", "ru"};

/// Keys by their places: 18 is that of the 9. A Russian keyboard has no < and >.
TEST_F(RealWindow, PlayerKeysFitEveryKeyboard) {
    if (!has_programs("setxkbmap xkbcomp")) GTEST_SKIP() << "setxkbmap and xkbcomp are not installed";
    for (const char* name : {"a.mkv", "b.mkv"}) make_clip(folder / name, "globe", 1);
    std::string actions = waits;
    for (const char* layout : all_layouts)
        actions += std::string("layout=") + layout + R"(
setxkbmap $layout || exit 97; sleep 0.3
xdotool key 18 sleep 0.2 key Next; until_called b.mkv
xdotool key Prior; until_called a.mkv
if [[ $layout != ru ]]; then
    xdotool key greater; until_called b.mkv
    xdotool key less; until_called a.mkv
fi
xdotool key F11; until_sized 1024x768
xdotool key Escape; until_sized 400x300
kill -0 $program || exit 96
)";
    const int code = run("play a.mkv b.mkv --size 400x300 --painter cpu",
                         actions + "setxkbmap us; sleep 0.3; xdotool key q\n");
    EXPECT_EQ(code, 0) << text("out") << text("err");
    EXPECT_TRUE(contains(kept(), "\"volume\": 70")) << "six times 5 less";
}

/// Where Q is printed; on a Russian keyboard, where an American one has it.
TEST_F(RealWindow, QClosesOnEveryKeyboard) {
    if (!has_programs("setxkbmap xkbcomp")) GTEST_SKIP() << "setxkbmap and xkbcomp are not installed";
    for (const std::string layout : all_layouts) {
        const int code =
            run("play globe.mkv --size 400x300 --painter cpu --seconds 60",
                "setxkbmap " + layout + "; sleep 0.3; xdotool key " + (layout == "ru" ? "24" : "q") + R"(
for k in $(seq 600); do kill -0 $program 2>/dev/null || break; sleep 0.1; done
kill -0 $program 2>/dev/null && { kill $program; exit 96; }
)");
        EXPECT_EQ(code, 0) << layout << text("err");
    }
}

/// Rows of the middle column, from below, until the bar's dark ground ends: it is over bright bumps.
int rows_of_bar(const Image& image) {
    const auto is_dark = [&](int y) {
        const auto k = static_cast<std::size_t>((y * image.width + image.width / 3) * 3);
        return image.samples[k] < 90 && image.samples[k + 2] < 90;
    };
    int rows = 0;
    for (int y = image.height / 2; y < image.height; ++y) rows += is_dark(y) ? 1 : 0;
    return rows;
}

/// A display whose resources say 192 pixels an inch has twice as many for the same words; --scale says
/// otherwise.
TEST_F(RealWindow, TextFollowsDisplayScale) {
    if (!has_programs("xprop")) GTEST_SKIP() << "xprop is not installed";
    make_clip(folder / "b.mkv", "bumps", 1);
    const auto bar_with = [&](const std::string& words, const std::string& dots, int width) {
        std::filesystem::remove(folder / "touchable-1.png");
        EXPECT_EQ(run("play b.mkv --size 480x300" + words,
                      "xdotool mousemove 20 150 sleep 0.5 key F12\n"
                      "for k in $(seq 600); do [[ -s touchable-1.png ]] && break; sleep 0.1; done\n"
                      "xdotool key q\n",
                      "xprop -root -f RESOURCE_MANAGER 8s -set RESOURCE_MANAGER 'Xft.dpi: " + dots + "'"),
                  0)
            << text("err");
        const auto image = read_image(folder / "touchable-1.png");
        EXPECT_TRUE(image);
        if (!image) return 0;
        EXPECT_EQ(image->width, width);
        return rows_of_bar(*image);
    };
    const int usual = bar_with("", "96", 480), dense = bar_with("", "192", 960);
    EXPECT_GT(usual, 20);
    EXPECT_GT(dense, 1.6 * usual);
    EXPECT_LT(bar_with(" --scale 1", "192", 960), 1.2 * usual);
}

TEST_F(RealWindow, DoubleClickFillsScreen) {
    const int code = run("play globe.mkv --size 400x300 --painter cpu", waits + std::string(R"(
xdotool mousemove 200 120 sleep 0.3 click 1 sleep 0.08 click 1; until_sized 1024x768
xdotool sleep 0.5 click 1 sleep 0.08 click 1; until_sized 400x300
xdotool key q
)"));
    EXPECT_EQ(code, 0) << text("out") << text("err");
}

/// `?` is Shift and another key on each; a Russian F is where an American one is.
TEST_F(RealWindow, HelpKeyFitsEveryKeyboard) {
    if (!has_programs("setxkbmap xkbcomp")) GTEST_SKIP() << "setxkbmap and xkbcomp are not installed";
    // Escape closes the help; the window, where there is none.
    const int code = run("play globe.mkv --size 400x300 --painter cpu", R"(
for layout in us de fr es se ru gr; do
    setxkbmap $layout || exit 97; sleep 0.3
    xdotool key question; sleep 0.3
    xdotool key Escape; sleep 0.3
    kill -0 $program 2>/dev/null || { echo "no help with $layout" >>out; exit 96; }
done
setxkbmap ru; sleep 0.3
xdotool key 56; sleep 0.3  # the place of B
setxkbmap us; sleep 0.3
xdotool key Escape
)");
    EXPECT_EQ(code, 0) << text("out") << text("err");
    EXPECT_TRUE(contains(kept(), "\"filters\": \"off\"")) << "B is there";
}

TEST_F(RealWindow, ShowsPointerWithoutFinger) {
    if (!has_programs("python3") || !has_library("libXfixes.so.3") || !has_library("libXcursor.so.1"))
        GTEST_SKIP() << "python3, libXfixes and libXcursor are not installed";
    std::ofstream(folder / "pointer.py") << R"(
from ctypes import *
class Image(Structure):
    _fields_ = [("x", c_short), ("y", c_short), ("width", c_ushort), ("height", c_ushort), ("xhot", c_ushort),
                ("yhot", c_ushort), ("serial", c_ulong), ("pixels", POINTER(c_ulong))]
x11, fixes = CDLL("libX11.so.6"), CDLL("libXfixes.so.3")
x11.XOpenDisplay.restype, fixes.XFixesGetCursorImage.restype = c_void_p, POINTER(Image)
display = c_void_p(x11.XOpenDisplay(None))
first, error = c_int(), c_int()
fixes.XFixesQueryExtension(display, byref(first), byref(error))
image = fixes.XFixesGetCursorImage(display).contents
print("seen" if any(image.pixels[k] >> 24 for k in range(image.width * image.height)) else "hidden")
)";
    const int code = run("play globe.mkv --size 400x300 --painter cpu", R"(
is() {
    for k in $(seq 30); do [[ $(python3 pointer.py) == "$1" ]] && break; sleep 0.3; done
    python3 pointer.py >>pointers
}
xdotool mousemove 200 120; is hidden
xdotool key f; is seen
xdotool key f; is hidden
xdotool key Escape
)");
    EXPECT_EQ(code, 0) << text("err");
    EXPECT_EQ(text("pointers"), "hidden\nseen\nhidden\n");
}

/// The CPU's picture in it, too.
/// By mouse and keys; the second window has what the first one did. Escape puts the brush away first.
TEST_F(RealWindow, PaintsByMouseAndKeys) {
    ASSERT_NO_FATAL_FAILURE(write_two_surfaces(folder / "wall.mkv", 4));
    const auto saved_by = [&](const std::string& keys) {
        const int code = run("play wall.mkv --size 960x640", R"(
xdotool key p sleep 0.3 mousemove 240 320 sleep 0.3 )" + keys + R"( sleep 0.3 key ctrl+s
for k in $(seq 600); do [[ -s wall.mkv.materials.json ]] && break; sleep 0.1; done
xdotool key Escape sleep 0.3
kill -0 $program || exit 96
xdotool key Escape
)");
        EXPECT_EQ(code, 0) << text("err");
        EXPECT_EQ(text("err"), "");
        const std::string text = file_contents(folder / "wall.mkv.materials.json");
        std::filesystem::remove(folder / "wall.mkv.materials.json");
        return text;
    };
    EXPECT_TRUE(contains(saved_by("click 1"), "wood"));
    EXPECT_EQ(names_in(folder / "state/touchable").size(), 1U);
    const std::string undone = saved_by("key ctrl+z");
    EXPECT_FALSE(contains(undone, "wood"));
    EXPECT_TRUE(contains(undone, "touchable_segments"));
    EXPECT_TRUE(contains(saved_by("key ctrl+y"), "wood")) << "done again in the next one";
}

/// It is set to a second after the window has opened; only a window that asks keeps it away.
TEST_F(RealWindow, KioskBlocksScreenSaver) {
    if (!has_programs("python3") || !has_library("libXss.so.1"))
        GTEST_SKIP() << "python3 and libXss are not installed";
    std::ofstream(folder / "saver.py") << R"(
from ctypes import *
import time
class Info(Structure):
    _fields_ = [("window", c_ulong), ("state", c_int), ("kind", c_int), ("since", c_ulong), ("idle", c_ulong),
                ("mask", c_ulong)]
x11, xss = CDLL("libX11.so.6"), CDLL("libXss.so.1")
x11.XOpenDisplay.restype, x11.XDefaultRootWindow.restype = c_void_p, c_ulong
display = c_void_p(x11.XOpenDisplay(None))
root, info = c_ulong(x11.XDefaultRootWindow(display)), Info()
x11.XSetScreenSaver(display, 1, 0, 1, 1)
for k in range(35):
    time.sleep(0.1)
    xss.XScreenSaverQueryInfo(display, root, byref(info))
    if info.state == 1: break
print("blank" if info.state == 1 else "awake")
)";
    const auto seen = [&](const std::string& words) {
        run("play globe.mkv --size 400x300 --painter cpu" + words, R"(
python3 saver.py >seen
kill $program
)");
        return text("seen");
    };
    EXPECT_EQ(seen(""), "blank\n");
#ifdef TOUCHABLE_HAS_XSS
    EXPECT_EQ(seen(" --kiosk"), "awake\n");
#endif
}

TEST_F(RealWindow, LostDisplayKeepsRecording) {
    // A server that hangs first: both threads are waiting for its answers when it goes away.
    for (const char* const ending : {"", "kill -STOP $server; sleep 0.5\n"}) {
        for (const char* const file : {"touchable-1.png", "hand.touch"})
            std::filesystem::remove(folder / file);
        const int code =
            run("play globe.mkv --size 400x300 --painter cpu --record hand.touch", std::string(R"(
xdotool mousemove 200 140 sleep 0.3 mousedown 1 sleep 0.3 key F12
for second in $(seq 60); do test -e touchable-1.png && break; sleep 1; done
)") + ending + "kill -9 $server\n");
        EXPECT_EQ(code, 4);
        expect_one_line(text("err"), "display");
        EXPECT_TRUE(read_image(folder / "touchable-1.png"));
        replayed(folder.path(), "hand.touch");
    }
}

/// Its server is stopped, at rest or while a picture is due; one signal ends the window.
TEST_F(RealWindow, HungDisplayEndsOnSignal) {
    const std::pair<std::string, std::string> rows[] = {
        {"", "TERM"}, {"", "INT"}, {"xdotool key space sleep 0.3\n", "TERM"}};
    for (const auto& [moves, signal] : rows) {
        std::filesystem::remove(folder / "hand.touch");
        const int code =
            run("play globe.mkv --loop 0 1 --size 400x300 --painter cpu --record hand.touch", std::string(R"(
xdotool mousemove 200 140 sleep 0.3 mousedown 1 sleep 0.6
)") + moves + R"(
kill -STOP $server; sleep 1; kill -)" + signal + R"( $program
for k in $(seq 300); do kill -0 $program 2>kill.log || break; sleep 0.1; done
kill -9 $program 2>kill.log
kill -CONT $server
)",
                "set -m  # a shell's background ignores Ctrl-C\n");
        EXPECT_EQ(code, 130);
        EXPECT_EQ(text("err"), "touchable: interrupted; written up to there: --record\n");
        replayed(folder.path(), "hand.touch");
    }
}

TEST_F(RealWindow, DestroyedWindowKeepsRecording) {
    const int code =
        run("play globe.mkv --size 400x300 --painter cpu --record hand.touch --video film.mkv", R"(
xdotool mousemove 200 140 sleep 0.6 windowclose $(head -1 window)
)");
    EXPECT_EQ(code, 4);
    expect_one_line(text("err"), "destroyed");
    EXPECT_TRUE(std::filesystem::exists(folder / "hand.touch"));
    EXPECT_TRUE(std::filesystem::exists(folder / "film.mkv"));
}

/// The thread that opened the screen never asks for input here, as while it draws or waits for a GPU.
TEST_F(RealWindow, HearsKeysDuringStandstill) {
    const std::string at = "cd '" + folder.path().string() + "'; ";
    ASSERT_EQ(std::system((at + R"(
Xvfb -displayfd 3 -screen 0 1024x768x24 -nolisten tcp -noreset 3>display >xvfb.log 2>&1 & echo $! >server
for k in $(seq 600); do [ -s display ] && exit 0; sleep 0.1; done; exit 1)")
                              .c_str()),
              0);
    const char* const outer = std::getenv("DISPLAY");
    const std::string display_before = outer ? outer : "";
    const std::string display = text("display");
    setenv("DISPLAY", (":" + display.substr(0, display.find('\n'))).c_str(), 1);
    std::atomic<int> heard{0};
    ScreenOptions options{.width = 320, .height = 200};
    options.at_once = [&](InputEvent& event) {
        if (event.word != "f") return;
        event.stopped_force = true;
        ++heard;
    };
    {
        const auto screen = open_glfw_screen(options);
        if (!screen) {
            EXPECT_EQ(std::system((at + "kill $(cat server)").c_str()), 0);
            FAIL() << screen.error().message;
        }
        EXPECT_EQ((*screen)->size().width, 320);
        EXPECT_EQ(std::system("timeout 60 xdotool search --sync --onlyvisible --name touchable >/dev/null && "
                              "xdotool mousemove 100 100 sleep 0.3 key f"),
                  0);
        EXPECT_TRUE(comes_true([&] { return heard == 1; }));
        EXPECT_TRUE(comes_true([&] {
            return std::ranges::any_of((*screen)->poll(std::chrono::milliseconds(1)), [](const auto& event) {
                return event.kind == InputEvent::Kind::key && event.word == "f" && event.stopped_force;
            });
        }));
        (*screen)->set_size(400, 300);
        EXPECT_EQ((*screen)->size().width, 400);
        EXPECT_TRUE((*screen)->health());
    }
    outer ? setenv("DISPLAY", display_before.c_str(), 1) : unsetenv("DISPLAY");
    EXPECT_EQ(std::system((at + "kill $(cat server)").c_str()), 0);
}

/// A desktop starts it so: without a terminal or a pipe that reads its lines.
TEST_F(RealWindow, DesktopWindowShowsFault) {
    std::ofstream(folder / "film.mkv") << "no clip";
    const int code = run(
        "play film.mkv --size 400x300 --painter cpu", R"(
until_there() { for k in $(seq 600); do [[ -e $1 ]] && return; xdotool key F12; sleep 0.1; done; }
until_there touchable-1.png
kill -0 $program || exit 96
xdotool key Escape sleep 0.3 key q
)",
        "\"$PROGRAM\" play film.mkv 2>&1 </dev/null | cat >piped; [[ ${PIPESTATUS[0]} == 3 ]] || exit 97\n");
    EXPECT_EQ(code, 3) << text("err");
    for (const char* said : {"err", "piped"}) expect_one_line(text(said), "film.mkv");
    EXPECT_TRUE(read_image(folder / "touchable-1.png"));
}

TEST(MissingDisplay, IsOneLine) {
    const TemporaryFolder folder;
    make_clip(folder / "b.mkv", "bumps", 2);
    std::ofstream(folder / "run.sh") << "env -u DISPLAY -u WAYLAND_DISPLAY \"" << TOUCHABLE_PROGRAM
                                     << "\" play '" << (folder / "b.mkv").string() << "' 2>'"
                                     << (folder / "err").string() << "'\n";
    const int status = std::system(("bash '" + (folder / "run.sh").string() + "'").c_str());
    EXPECT_EQ(WEXITSTATUS(status), 4);
    expect_one_line(file_contents(folder / "err"), "--headless");
}

}  // namespace
}  // namespace touchable::test
