// Whatever a person, a cat or a child does to the window, it goes on, and no force is above the limit.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>

#include "player/window/command_table.hpp"
#include "player/window/window_command.hpp"
#include "tests/player/program.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

/// Seconds of it; longer by TOUCHABLE_RANDOM_SECONDS.
double seconds_of_input() {
    const char* const asked = std::getenv("TOUCHABLE_RANDOM_SECONDS");
    return asked ? std::atof(asked) : 2;
}

class RandomScript {
public:
    explicit RandomScript(unsigned seed) : random_(seed) {}

    std::string of(double seconds) {
        std::ostringstream out;
        out << "0 move 320 200\n0 press left\n";
        for (double at = 0.8; at < seconds; at += 0.001 * below(60)) out << at << ' ' << something() << '\n';
        return out.str();
    }

private:
    int below(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
    std::string number(int below_this) { return std::to_string(below(below_this)); }

    std::string something() {
        const char* const buttons[] = {"left", "right", "middle"};
        switch (below(17)) {
            case 0:
            case 1:
            case 2:
            case 3:
                return "move " + number(700) + ' ' + number(420);
            case 4:
                return std::string("press ") + buttons[below(3)];
            case 5:
                return std::string("release ") + buttons[below(3)];
            case 6:
                return "wheel " + std::to_string(below(7) - 3);
            case 7:
                return "seek 0." + number(100);
            case 8:
                return "size " + std::to_string(64 + below(700)) + 'x' + std::to_string(64 + below(400));
            case 9:
                return "drop nowhere-" + number(9);
            case 10:
            case 11:
                return "touch " + finger() + ' ' + number(700) + ' ' + number(420);
            case 12:
            case 13:
                return "touch-move " + finger() + ' ' + number(700) + ' ' + number(420);
            case 14:
                return below(8) == 0 ? "leave" : "touch-end " + finger();
            default:
                return key();
        }
    }

    std::string finger() { return std::to_string(1 + below(7)); }

    /// Any but those that end it, leave files or fill the screen.
    std::string key() {
        const auto keys = key_bindings();
        for (;;) {
            const KeyBinding& one = keys[static_cast<std::size_t>(below(static_cast<int>(keys.size())))];
            if (!one.shift && !one.control && one.verb != WindowVerb::quit && one.verb != WindowVerb::leave &&
                one.verb != WindowVerb::screenshot && one.verb != WindowVerb::fullscreen)
                return std::string("key ") + one.key;
        }
    }

    std::minstd_rand random_;
};

TEST(RandomInput, EndsWellAndNoForceIsAboveTheLimit) {
    const TemporaryFolder folder;
    const std::string clip = (folder / "globe.mkv").string(), record = (folder / "hand.touch").string();
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--size", "160x120", "--frames", "30"}).code, 0);
    const double seconds = seconds_of_input();
    const auto played = run_scripted({clip, "--seconds", std::to_string(seconds + 0.2), "--record", record},
                                     RandomScript(20).of(seconds), folder.path(), "640x400");
    ASSERT_EQ(played.code, 0) << played.err;
    const auto again = run_touchable({"touch", "--replay", record, "--json", "-"});
    ASSERT_EQ(again.code, 0) << again.err;
    const auto report = nlohmann::json::parse(again.out);
    EXPECT_GT(report.at("force_n").at("max").get<double>(), 0) << "nothing was touched";
    EXPECT_LE(report.at("force_n").at("max").get<double>(), 10) << "the usual --max-force";
}

}  // namespace
}  // namespace touchable::test
