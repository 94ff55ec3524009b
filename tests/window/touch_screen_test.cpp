// SPDX-License-Identifier: Apache-2.0
// Fingers on a touch screen, in the program as a person starts it: by scripts, and on an Xorg that has one.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "engine/base/files.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

/// The forces in a recording.
class Felt {
public:
    explicit Felt(const std::filesystem::path& recording) {
        const TemporaryFolder folder;
        const std::string csv = (folder / "forces.csv").string();
        const auto again = run_in_folder({"touch", "--replay", recording.string(), "--forces", csv},
                                         recording.parent_path());
        EXPECT_EQ(again.code, 0) << again.err;
        EXPECT_TRUE(contains(again.out, "as recorded, to the bit"));
        read(csv);
    }
    std::size_t ticks() const { return x_.size() / fingers; }
    bool pushes(std::size_t tick, std::size_t finger) const {
        const std::size_t row = tick * fingers + finger;
        return x_[row] != 0 || y_[row] != 0 || z_[row] != 0;
    }
    /// It is not meant to touch: where fingers are that are away, at the clip's camera.
    bool is_away_in_the_end(std::size_t finger) const {
        return ticks() > 0 && goal_z_[(ticks() - 1) * fingers + finger] > -1;
    }
    int pushing(std::size_t tick) const {
        int count = 0;
        for (std::size_t finger = 0; finger < fingers; ++finger) count += pushes(tick, finger);
        return count;
    }
    int most_pushing() const {
        int most = 0;
        for (std::size_t tick = 0; tick < ticks(); ++tick) most = std::max(most, pushing(tick));
        return most;
    }
    int pushing_in_the_end() const { return ticks() > 0 ? pushing(ticks() - 1) : -1; }
    int ticks_of(std::size_t finger) const {
        int count = 0;
        for (std::size_t tick = 0; tick < ticks(); ++tick) count += pushes(tick, finger);
        return count;
    }

private:
    /// Does not use read_force_table: on a busy machine ticks are left out.
    void read(const std::string& csv) {
        const auto table = CsvTable::read(csv);
        ASSERT_TRUE(table) << table.error().message;
        const auto column = [&](const char* name) { return *table->numbers(*table->column(name)); };
        goal_z_ = column("goal_z");
        x_ = column("force_x");
        y_ = column("force_y");
        z_ = column("force_z");
    }

    static constexpr std::size_t fingers = 5;
    std::vector<double> goal_z_, x_, y_, z_;
};

struct Touched {
    Image image;
    Felt felt;
};

/// The window's picture and the forces `seconds` after it opened.
Touched play(const std::string& script, const std::string& seconds) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string();
    const Played played =
        played_by({made_clip("globe", 1).string(), "--record", record}, script, seconds, "640x480");
    return {played.image, Felt(record)};
}

/// Pixels of the picture's part without panels that are unlike.
int surface_differences(const Image& a, const Image& b) {
    return differences(a, b, {140, 120, 600, 400});
}

TEST(TouchScript, FingersTouchSeparately) {
    const Touched played = play(
        "0.1 touch 1 290 220\n0.5 touch 2 350 230\n0.6 touch-move 1 300 240\n0.9 touch 3 320 300\n"
        "1.2 touch-end 2\n1.4 touch-end 1\n1.4 touch-end 3\n",
        "1.8");
    EXPECT_EQ(played.felt.most_pushing(), 3);
    for (std::size_t finger = 0; finger < 3; ++finger) EXPECT_GT(played.felt.ticks_of(finger), 100) << finger;
    EXPECT_EQ(played.felt.ticks_of(3), 0);
    EXPECT_EQ(played.felt.pushing_in_the_end(), 0);
}

TEST(TouchScript, TwoFingersTurnAndZoom) {
    const Touched without = play("", "0.5");
    const Touched zoomed = play(
        "0.1 touch 1 290 220\n0.15 touch 2 350 230\n0.2 touch-move 1 250 220\n0.2 touch-move 2 390 230\n"
        "0.3 touch-move 1 210 220\n0.3 touch-move 2 430 230\n0.4 touch-end 1\n0.4 touch-end 2\n",
        "0.9");
    const Touched turned = play(
        "0.1 touch 1 290 220\n0.15 touch 2 350 230\n0.2 touch-move 1 290 250\n0.2 touch-move 2 350 260\n"
        "0.3 touch-move 1 290 320\n0.3 touch-move 2 350 330\n0.4 touch-end 1\n0.4 touch-end 2\n",
        "0.9");
    EXPECT_GT(surface_differences(without.image, zoomed.image), 5000);
    EXPECT_GT(surface_differences(without.image, turned.image), 5000);
    EXPECT_GT(surface_differences(zoomed.image, turned.image), 5000);
    EXPECT_EQ(zoomed.felt.pushing_in_the_end(), 0);
}

/// Another window has the focus while fingers are still on the glass.
TEST(TouchScript, LeavingWindowLiftsFingers) {
    const Touched left =
        play("0.1 touch 1 290 220\n0.5 touch 2 350 230\n0.9 leave\n1 touch-move 1 300 240\n", "1.5");
    EXPECT_EQ(left.felt.most_pushing(), 2);
    EXPECT_EQ(left.felt.pushing_in_the_end(), 0);
    const Touched stayed = play("0.1 touch 1 290 220\n0.5 touch 2 350 230\n1 touch-move 1 300 240\n", "1.5");
    EXPECT_EQ(stayed.felt.pushing_in_the_end(), 2);
}

TEST(TouchScript, FingerPressesButtons) {
    // The question mark, right in the bar below.
    const std::string place = "605 446";
    // A touch comes first: the help names touch screens only where there is one.
    const Touched by_mouse = play("0.05 touch 1 20 470\n0.1 touch-end 1\n0.2 move " + place +
                                      "\n0.3 press left\n0.4 release left\n0.5 move 2 2\n",
                                  "1");
    const Touched by_finger = play("0.3 touch 1 " + place + "\n0.4 touch-end 1\n", "1");
    const Touched without = play("", "1");
    EXPECT_GT(surface_differences(without.image, by_mouse.image), 5000) << "no help";
    EXPECT_LT(surface_differences(by_mouse.image, by_finger.image), 100);
    EXPECT_EQ(by_finger.felt.most_pushing(), 0);
}

TEST(TouchScript, HomeAndSettingsButtonsWork) {
    const Touched own = play("", "1"), turned = play("0.1 turn 30\n", "1"),
                  home = play("0.1 turn 30\n0.3 touch 1 406 444\n0.4 touch-end 1\n", "1"),
                  panel = play("0.3 touch 1 543 444\n0.4 touch-end 1\n", "1"),
                  by_key = play("0.3 key tab\n", "1");
    EXPECT_GT(surface_differences(own.image, turned.image), 3000);
    EXPECT_LT(surface_differences(own.image, home.image), 100);
    EXPECT_GT(surface_differences(own.image, by_key.image), 3000);
    EXPECT_LT(surface_differences(by_key.image, panel.image), 300);
    const Touched menu = play("0.3 panel\n0.4 touch 1 560 239\n0.5 touch-end 1\n", "1");
    EXPECT_GT(differences(panel.image, menu.image, {20, 20, 280, 220}), 3000)
        << "the panel's button has no menu";
}

TEST(TouchScript, HintFollowsMouseOrFinger) {
    const PicturePart top{140, 0, 500, 60};
    const std::string on_bar = "0.3 touch 1 100 428\n0.4 touch-end 1\n";  // the bar, where it has no button
    const Touched mouse = play("", "1"), finger = play(on_bar, "1"),
                  gone = play("0.3 move 320 200\n0.4 press left\n0.5 release left\n0.6 leave\n", "1");
    EXPECT_GT(differences(mouse.image, finger.image, top), 300) << "it speaks of the mouse";
    EXPECT_GT(differences(finger.image, gone.image, top), 300) << "it says nothing";
}

/// A kiosk's picture by these texts, without the bar, which has the way back where it is there.
Image kiosk_in(const std::string& language, const std::string& script) {
    return played_by(
               {made_clip("globe", 1).string(), "--kiosk", "--kiosk-bar", "off", "--kiosk-texts", language},
               script, "1", "640x480")
        .image;
}

TEST(TouchScript, KioskTranslatesTextsAndResets) {
    const std::string touch = "0.1 touch 1 320 200\n0.2 touch-end 1\n", depth = touch + "0.3 key o\n";
    const PicturePart limit{12, 150, 140, 220}, legend{360, 400, 640, 480}, back{440, 0, 640, 60};
    const Image en = kiosk_in("en", depth), de = kiosk_in("de", depth), plain = kiosk_in("en", touch);
    EXPECT_GT(differences(en, plain, legend), 1000) << "no legend";
    EXPECT_GT(differences(en, de, limit), 20);
    EXPECT_GT(differences(en, de, legend), 20);
    const Image turned = kiosk_in("en", touch + "0.3 turn 30\n");
    EXPECT_GT(differences(turned, plain, back), 1000) << "no way back";
    EXPECT_GT(surface_differences(turned, plain), 3000);
    const Image home = kiosk_in("en", touch + "0.3 turn 30\n0.6 touch 2 580 40\n0.7 touch-end 2\n");
    EXPECT_LT(surface_differences(home, plain), 100);
    EXPECT_LT(differences(home, plain, back), 100);
}

/// An Xorg without a screen, with a touch screen, a mouse and keys that programs move.
constexpr const char* xorg_conf = R"(
Section "ServerFlags"
    Option "AutoAddDevices" "false"
    Option "AutoAddGPU" "false"
    Option "DontVTSwitch" "true"
EndSection
Section "Device"
    Identifier "card"
    Driver "dummy"
    VideoRam 16384
EndSection
Section "Monitor"
    Identifier "monitor"
    HorizSync 5-1000
    VertRefresh 5-200
    Modeline "1024x768" 65 1024 1048 1184 1344 768 771 777 806
EndSection
Section "Screen"
    Identifier "screen"
    Device "card"
    Monitor "monitor"
    DefaultDepth 24
    SubSection "Display"
        Modes "1024x768"
    EndSubSection
EndSection
Section "InputDevice"
    Identifier "fingers"
    Driver "inputtest"
    Option "DeviceType" "Touch"
    Option "SocketPath" "FOLDER/fingers"
EndSection
Section "InputDevice"
    Identifier "mouse"
    Driver "inputtest"
    Option "DeviceType" "PointerAbsolute"
    Option "SocketPath" "FOLDER/mouse"
EndSection
Section "InputDevice"
    Identifier "keys"
    Driver "inputtest"
    Option "DeviceType" "Keyboard"
    Option "SocketPath" "FOLDER/keys"
EndSection
Section "ServerLayout"
    Identifier "layout"
    Screen "screen"
    InputDevice "fingers"
    InputDevice "mouse" "CorePointer"
    InputDevice "keys" "CoreKeyboard"
EndSection
)";

/// `down,FINGER,X,Y`, `move,...`, `up,FINGER` and `sleep,SECONDS`, by the protocol of Xorg's inputtest
/// driver.
constexpr const char* fingers_py = R"(
import socket, struct, subprocess, sys, time
begin, update, end = 18, 19, 20  # XI_TouchBegin and so on
wait_for_sync, touch_event = 1, 6
class Fingers:
    def __init__(self, path, width, height):
        self.size = width, height
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(path)
        self.socket.sendall(struct.pack("IIHH", 12, 0, 1, 1))
        self.answer()
    def answer(self):
        length = struct.unpack("I", self.socket.recv(4, socket.MSG_WAITALL))[0]
        self.socket.recv(length - 4, socket.MSG_WAITALL)
    def send(self, kind, finger, x=0, y=0):
        values = [x * 65535 / (self.size[0] - 1), y * 65535 / (self.size[1] - 1)] + [0] * 62
        mask = 0 if kind == end else 3
        self.socket.sendall(struct.pack("IIIII8s4x64d64d", 1056, touch_event, finger, kind, 0,
                                        bytes([mask] + [0] * 7), *values, *[0.0] * 64))
        self.socket.sendall(struct.pack("II", 8, wait_for_sync))
        self.answer()
fingers = Fingers("fingers", 1024, 768)
for word in sys.argv[1:]:
    kind, _, rest = word.partition(",")
    if kind == "sleep": time.sleep(float(rest))
    elif kind == "do": subprocess.run(rest, shell=True)
    else: fingers.send({"down": begin, "move": update, "up": end}[kind], *map(int, rest.split(",")))
)";

/// On such an Xorg, as `run_on_display`: exit code 99 where it does not start.
int with_touch_screen(const TemporaryFolder& folder, const std::string& words, const std::string& actions) {
    std::string conf = xorg_conf;
    for (std::size_t at; (at = conf.find("FOLDER")) != std::string::npos;)
        conf.replace(at, 6, folder.path().string());
    std::ofstream(folder / "xorg.conf") << conf;
    std::ofstream(folder / "fingers.py") << fingers_py;
    return run_on_display(folder.path(), R"(
Xorg -displayfd 3 -config "$PWD/xorg.conf" -logfile "$PWD/xorg.log" -noreset -nolisten tcp 3>display >xorg.out 2>&1 & server=$!
trap 'kill $server 2>/dev/null; wait $server' EXIT
for k in $(seq 100); do [[ -s display && -S fingers ]] && break; kill -0 $server 2>/dev/null || exit 99; sleep 0.1; done
[[ -s display && -S fingers ]] || exit 99
export DISPLAY=:$(cat display) XDG_CONFIG_HOME=$PWD/config XDG_STATE_HOME=$PWD/state
)",
                          words, actions);
}

#define SKIP_WITHOUT_XORG(code)                                                    \
    if ((code) == 99)                                                              \
    GTEST_SKIP() << "no Xorg with a touch screen starts here (xserver-xorg-core, " \
                    "xserver-xorg-video-dummy; as root)"

class XorgTouchScreen : public ::testing::Test {
protected:
    void SetUp() override {
        if (std::system("command -v Xorg xdotool python3 >/dev/null") != 0)
            GTEST_SKIP() << "Xorg, xdotool and python3 are not installed";
        if (!has_touches) GTEST_SKIP() << "built without libxi-dev";
        std::filesystem::copy_file(made_clip("globe", 1), folder_ / "globe.mkv");
    }
    TemporaryFolder folder_;
#ifdef TOUCHABLE_HAS_TOUCHES
    static constexpr bool has_touches = true;
#else
    static constexpr bool has_touches = false;
#endif
};

TEST_F(XorgTouchScreen, IgnoresPointerEmulation) {
    const int code =
        with_touch_screen(folder_, "play globe.mkv --size 640x480 --painter cpu --record hand.touch", R"(
python3 fingers.py down,0,290,220 sleep,0.6 down,1,350,230 sleep,0.4 move,0,300,240 sleep,0.3 down,2,320,300 \
    sleep,0.5 up,1 sleep,0.2 up,0 up,2 sleep,0.7
xdotool key Escape
)");
    SKIP_WITHOUT_XORG(code);
    ASSERT_EQ(code, 0) << file_contents(folder_ / "err");
    const Felt felt(folder_ / "hand.touch");
    EXPECT_EQ(felt.most_pushing(), 3);
    for (std::size_t finger = 0; finger < 3; ++finger) EXPECT_GT(felt.ticks_of(finger), 20) << finger;
    EXPECT_EQ(felt.pushing_in_the_end(), 0);
    for (std::size_t finger = 0; finger < 5; ++finger)
        EXPECT_TRUE(felt.is_away_in_the_end(finger)) << finger << " stays where the pointer is";
}

TEST_F(XorgTouchScreen, GesturesTurnAndClick) {
    const int code = with_touch_screen(folder_, "play globe.mkv --size 640x480 --painter cpu", R"(
echo 'xdotool key F12; for k in $(seq 100); do test -e touchable-$1.png && break; sleep 0.1; done' >shot.sh
sleep 0.5
python3 fingers.py 'do,bash shot.sh 1' down,0,290,220 down,1,350,230 move,0,250,220 move,1,390,230 move,0,210,220 \
    move,1,430,230 up,0 up,1 sleep,0.7 'do,bash shot.sh 2' down,0,605,446 sleep,0.2 up,0 sleep,0.5 'do,bash shot.sh 3'
xdotool key Escape sleep 0.3 key Escape
)");
    SKIP_WITHOUT_XORG(code);
    EXPECT_EQ(code, 0) << file_contents(folder_ / "err");
    const auto first = read_image(folder_ / "touchable-1.png"),
               zoomed = read_image(folder_ / "touchable-2.png"),
               help = read_image(folder_ / "touchable-3.png");
    ASSERT_TRUE(first && zoomed && help);
    EXPECT_GT(surface_differences(*first, *zoomed), 5000);
    EXPECT_GT(surface_differences(*zoomed, *help), 5000);
}

TEST_F(XorgTouchScreen, LostScreenEndsForces) {
    const int code =
        with_touch_screen(folder_, "play globe.mkv --size 640x480 --painter cpu --record hand.touch", R"(
python3 fingers.py down,0,290,220 sleep,0.6 down,1,350,230 sleep,0.6
kill -9 $server
)");
    SKIP_WITHOUT_XORG(code);
    EXPECT_EQ(code, 4);
    EXPECT_TRUE(contains(file_contents(folder_ / "err"), "display"));
    EXPECT_EQ(Felt(folder_ / "hand.touch").most_pushing(), 2);
}

}  // namespace
}  // namespace touchable::test
