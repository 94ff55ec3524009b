// A window's modes without a window: which of them takes what comes, and what the core asks them.
#include <gtest/gtest.h>

#include <string>

#include "player/window/kiosk_mode.hpp"

namespace touchable::test {
namespace {

TEST(WindowCore, RefusesCommandsWithoutClip) {
    WindowCore core{PlayOptions{}};
    core.take(WindowCommand{WindowVerb::play_pause});
    EXPECT_EQ(core.notices.passing(), "there is no clip yet: drop one on the window");
    EXPECT_TRUE(core.notices.is_refusal());
    EXPECT_FALSE(core.quits());
    core.take(WindowCommand{WindowVerb::quit});
    EXPECT_TRUE(core.quits());
}

TEST(WindowCore, HasModesThatTakeNothingAtFirst) {
    WindowCore core{PlayOptions{}};
    EXPECT_EQ(core.modes().size(), 4U);
    for (const auto question :
         {&WindowMode::is_unattended, &WindowMode::is_at_work, &WindowMode::moves_by_itself,
          &WindowMode::repeats_clip, &WindowMode::keeps_view, &WindowMode::chooses_clip,
          &WindowMode::keeps_session, &WindowMode::hides_forces})
        EXPECT_FALSE(core.any(question));
    EXPECT_FALSE(core.any_button(LeftButton::is_a_tool) || core.any_button(LeftButton::turns_view));
    for (WindowMode* const mode : core.modes()) {
        EXPECT_FALSE(mode->handle(InputEvent{.kind = InputEvent::Kind::pressed, .word = "left"}));
        EXPECT_FALSE(mode->leave());
    }
}

TEST(WindowCore, SaysAFaultOfAFileOnce) {
    WindowCore core{PlayOptions{}};
    EXPECT_TRUE(core.is_new_fault(input_error("the disk is full")));
    EXPECT_FALSE(core.is_new_fault(input_error("the disk is full")));
}

TEST(KioskMode, TakesWhatVisitorsMayNotDo) {
    PlayOptions options;
    options.kiosk.emplace();
    WindowCore core{std::move(options)};
    KioskMode kiosk(core, {});
    using Kind = InputEvent::Kind;
    EXPECT_TRUE(kiosk.handle(InputEvent{.kind = Kind::close}));
    EXPECT_TRUE(kiosk.handle(InputEvent{.kind = Kind::dropped, .word = "clip.mkv"}));
    EXPECT_TRUE(kiosk.handle(InputEvent{.kind = Kind::key, .word = "q"}));
    EXPECT_FALSE(kiosk.handle(InputEvent{.kind = Kind::key, .word = "space"}));
    EXPECT_FALSE(kiosk.handle(InputEvent{.kind = Kind::moved, .x = 1, .y = 1}));
}

TEST(KioskMode, SaysNothingWithoutClip) {
    PlayOptions options;
    options.kiosk.emplace();
    WindowCore core{std::move(options)};
    KioskMode kiosk(core, {});
    EXPECT_TRUE(kiosk.handle(WindowCommand{WindowVerb::play_pause}));
    EXPECT_FALSE(kiosk.handle(WindowCommand{WindowVerb::mute})) << "which needs no clip";
    EXPECT_EQ(core.notices.passing(), "");
    EXPECT_TRUE(kiosk.is_unattended() && kiosk.repeats_clip());
    EXPECT_FALSE(kiosk.moves_by_itself() || kiosk.keeps_view() || kiosk.chooses_clip());
}

}  // namespace
}  // namespace touchable::test
