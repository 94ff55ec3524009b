// A machine that is suspended while somebody presses.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "player/run/run_files.hpp"
#include "player/window/play_window.hpp"
#include "player/window/window_clock.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/wrapped_screen.hpp"

namespace touchable::test {
namespace {

using namespace std::chrono_literals;

/// That sleeps for an hour once its window is as large as that.
class SleepyScreen final : public WrappedScreen {
public:
    using WrappedScreen::WrappedScreen;
    void set_size(int, int) override { WindowClock::suspend(1h); }
};

/// Newtons on the first finger at the end, and the most there were, of somebody who presses; `sleeps`: the
/// machine does meanwhile.
std::pair<double, double> felt(const std::vector<ScriptedInput>& press, bool sleeps) {
    const TemporaryFolder folder;
    PlayOptions options;
    options.session.clip.file = made_clip("globe", 1);
    options.session.builder.name = options.painter = "cpu";
    options.headless = true;
    options.screen.width = 320;
    options.screen.height = 240;
    options.make_screen = [](const ScreenOptions& size) { return std::make_unique<SleepyScreen>(size); };
    options.record = folder / "hand.touch";
    options.script = press;
    if (sleeps) options.script.push_back({1, WindowCommand{.verb = WindowVerb::size}});
    options.seconds = 1.8;
    const auto played = play_in_window(options);
    EXPECT_TRUE(played) << played.error().message;
    const auto recording = read_recording(folder / "hand.touch");
    EXPECT_TRUE(recording);
    double most = 0, last = -1;
    if (recording)
        for (const auto& tick : recording->back().ticks)
            most = std::max(most, last = glm::length(tick.forces[0]));
    return {last, most};
}

TEST(SuspendedMachine, LiftsFingersAndButtons) {
    using Kind = InputEvent::Kind;
    const std::vector<ScriptedInput> finger{
        {0.1, InputEvent{.kind = Kind::touch_began, .x = 160, .y = 100, .touch = 1, .seconds = 0.1}},
        {1.2, InputEvent{.kind = Kind::touch_moved, .x = 161, .y = 100, .touch = 1, .seconds = 1.2}}};
    const std::vector<ScriptedInput> mouse{{0.1, InputEvent{.x = 160, .y = 100}},
                                           {0.1, InputEvent{.kind = Kind::pressed, .word = "left"}}};
    for (const auto* press : {&finger, &mouse}) {
        EXPECT_GT(felt(*press, false).first, 0.05);
        const auto [last, most] = felt(*press, true);
        EXPECT_GT(most, 0.05) << "nothing was pressed";
        EXPECT_EQ(last, 0);
    }
}

}  // namespace
}  // namespace touchable::test
