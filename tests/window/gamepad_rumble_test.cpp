// SPDX-License-Identifier: Apache-2.0
// Contact as a gamepad's rumble: by ticks and times that the test makes, and on SDL's virtual gamepad.
#include <gtest/gtest.h>

#ifdef TOUCHABLE_HAS_SDL
#define SDL_MAIN_HANDLED
#include <SDL.h>
#include <dlfcn.h>
#endif

#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

#include "player/audio/window_sound.hpp"

#ifdef TOUCHABLE_HAS_SDL
static bool closed_in_time = true;

/// SDL's, which sees whether SDL has ended, and with it the gamepad.
extern "C" void SDL_GameControllerClose(SDL_GameController* pad) {
    static const auto close =
        reinterpret_cast<decltype(&SDL_GameControllerClose)>(dlsym(RTLD_NEXT, "SDL_GameControllerClose"));
    closed_in_time = closed_in_time && SDL_WasInit(SDL_INIT_GAMECONTROLLER) != 0;
    close(pad);
}
#endif

namespace touchable::test {
namespace {

HeardTick touching(float newtons, float slip = 0, float change = 0) {
    HeardTick tick;
    tick.fingers[1] = {.touching = true, .newtons = newtons, .slip = slip, .change = change};
    return tick;
}

Rumble after(ContactRumble& rumble, const HeardTick& tick, int ticks) {
    for (int k = 1; k < ticks; ++k) rumble.next(tick);
    return rumble.next(tick);
}

TEST(ContactRumble, MotorsFollowForceAndTexture) {
    ContactRumble rumble;
    EXPECT_EQ(rumble.next({}), Rumble());
    const Rumble soft = after(rumble, touching(0.5F), 100), hard = after(rumble, touching(5), 100);
    EXPECT_GT(soft.low, 0.05F);
    EXPECT_GT(hard.low, 1.5F * soft.low);
    EXPECT_EQ(soft.high, 0);
    const Rumble smooth = after(rumble, touching(2, 0.1F, 0.0005F), 300),
                 rough = after(rumble, touching(2, 0.1F, 0.1F), 300),
                 resting = after(rumble, touching(2, 0, 0.1F), 300);
    EXPECT_LT(smooth.high, 0.05F);
    EXPECT_GT(rough.high, 0.5F);
    EXPECT_LT(resting.high, 0.01F) << "who does not slip feels no texture";
}

TEST(ContactRumble, KnocksOnContactAndRelease) {
    for (const bool meets : {true, false}) {
        ContactRumble rumble;
        const float before = after(rumble, touching(1), 100).low;
        HeardTick event = touching(1);
        (meets ? event.fingers[1].met : event.fingers[1].let_go) = 1;
        const float knock = rumble.next(event).low;
        EXPECT_GT(knock, before + 0.2F);
        EXPECT_GT(after(rumble, touching(1), 10).low, before) << "long enough for a motor";
        EXPECT_FLOAT_EQ(after(rumble, touching(1), 500).low, before);
    }
}

TEST(ContactRumble, IsZeroWithoutForce) {
    ContactRumble rumble;
    HeardTick loud = touching(5, 1, 1);
    loud.fingers[1].met = 5;
    EXPECT_GT(rumble.next(loud).low, 0.5F);
    HeardTick off = loud;  // forces of a held device are off, and it is inside the surface
    off.fingers[1].newtons = 0;
    EXPECT_EQ(rumble.next(off), Rumble());
    EXPECT_GT(rumble.next(loud).high, 0);
    EXPECT_EQ(rumble.next({}), Rumble()) << "the hand has left";
    EXPECT_EQ(rumble.next(touching(1)).high, 0) << "and nothing of before comes back";
}

TEST(ContactRumble, ClampsAnyInput) {
    constexpr float infinite = std::numeric_limits<float>::infinity(), nan = NAN;
    ContactRumble rumble;
    for (const float a : {nan, infinite, -infinite, 1e30F, -1.0F, 0.5F})
        for (const float b : {nan, infinite, -infinite, 1e30F, -1.0F, 0.5F}) {
            HeardTick tick = touching(a, b, a);
            tick.fingers[1].met = b;
            tick.fingers[1].let_go = a;
            const Rumble now = rumble.next(tick);
            for (const float motor : {now.low, now.high}) EXPECT_TRUE(motor >= 0 && motor <= 1) << motor;
        }
}

TEST(RumbleOrders, RepeatBeforeTheyExpire) {
    RumbleOrders orders;
    const Rumble felt{0.5F, 0.2F};
    EXPECT_FALSE(orders.at(0, {}, 0)) << "nothing was felt yet";
    EXPECT_EQ(orders.at(0.01, felt, 1), felt);
    double last = 0.01;
    for (int k = 2; k < 200; ++k) {
        const double now = 0.01 * k;
        if (!orders.at(now, felt, k)) continue;
        EXPECT_LT(now - last, RumbleOrders::lasts_ms / 1000.0) << "the motors stopped in between";
        EXPECT_GT(now - last, 0.03) << "no need to tell that often";
        last = now;
    }
    EXPECT_GT(last, 1.8);
    EXPECT_EQ(orders.at(2, {}, 300), Rumble()) << "at once";
    EXPECT_FALSE(orders.at(2.01, {}, 301));
    EXPECT_EQ(orders.at(2.02, felt, 302), felt);
    orders.forget();
    EXPECT_EQ(orders.at(2.03, felt, 303), felt) << "another gamepad";
}

TEST(RumbleOrders, StopMotorsWithoutTicks) {
    RumbleOrders orders;
    const Rumble felt{0.5F, 0.2F};
    EXPECT_TRUE(orders.at(1, felt, 100));
    double stopped = 0;
    for (int k = 1; k < 100 && stopped == 0; ++k)
        if (orders.at(1 + 0.01 * k, felt, 100) == Rumble()) stopped = 0.01 * k;
    EXPECT_GT(stopped, 0);
    EXPECT_LE(stopped, RumbleOrders::tick_lasts_s + 0.011);
    EXPECT_FALSE(orders.at(3, felt, 100)) << "it stays so";
    EXPECT_EQ(orders.at(4, felt, 101), felt);
}

#ifdef TOUCHABLE_HAS_SDL

/// Gamepads of SDL's own, and what their motors were told last.
class VirtualGamepad {
public:
    struct Told {
        std::mutex mutex;
        std::vector<std::array<std::uint16_t, 2>> orders;
        std::array<std::uint16_t, 2> last() {
            const std::lock_guard lock(mutex);
            return orders.empty() ? std::array<std::uint16_t, 2>{0, 0} : orders.back();
        }
        bool is_told() {
            const std::lock_guard lock(mutex);
            return !orders.empty();
        }
    };
    explicit VirtualGamepad(Told& told) {
        SDL_VirtualJoystickDesc has{};
        has.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
        has.type = SDL_JOYSTICK_TYPE_GAMECONTROLLER;
        has.naxes = SDL_CONTROLLER_AXIS_MAX;
        has.nbuttons = SDL_CONTROLLER_BUTTON_MAX;
        has.name = "virtual pad";
        has.userdata = &told;
        has.Rumble = [](void* to, Uint16 low, Uint16 high) {
            auto& all = *static_cast<Told*>(to);
            const std::lock_guard lock(all.mutex);
            all.orders.push_back({low, high});
            return 0;
        };
        index_ = SDL_JoystickAttachVirtualEx(&has);
    }
    ~VirtualGamepad() { SDL_JoystickDetachVirtual(index_); }
    bool is_there() const { return index_ >= 0; }

private:
    int index_ = -1;
};

/// SDL stays, so that what the test attaches does.
class RumblingGamepad : public ::testing::Test {
protected:
    void SetUp() override {
        SDL_SetMainReady();
        SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
        SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
        ASSERT_EQ(SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER), 0) << SDL_GetError();
        for (int k = 0; k < SDL_NumJoysticks(); ++k)
            if (SDL_IsGameController(k)) GTEST_SKIP() << "a real gamepad is plugged in";
    }
    void TearDown() override { SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER); }
    VirtualGamepad::Told told_;
};

TEST_F(RumblingGamepad, IsPluggedAndUnplugged) {
    auto opened = Gamepad::open();
    ASSERT_TRUE(opened) << opened.error().message;
    Gamepad& pad = **opened;
    EXPECT_EQ(pad.look(), "");
    pad.rumble({1, 1}, 100);
    {
        const VirtualGamepad one(told_);
        ASSERT_TRUE(one.is_there()) << SDL_GetError();
        EXPECT_NE(pad.look(), "");
        pad.rumble({0.5F, 1}, 100);
        EXPECT_EQ(told_.last(), (std::array<std::uint16_t, 2>{32768, 65535}));
        pad.rumble({}, 0);
        EXPECT_EQ(told_.last(), (std::array<std::uint16_t, 2>{0, 0}));
    }
    EXPECT_EQ(pad.look(), "");
    pad.rumble({1, 1}, 100);
    VirtualGamepad::Told again;
    const VirtualGamepad other(again);
    EXPECT_NE(pad.look(), "");
    pad.rumble({1, 0}, 100);
    EXPECT_EQ(again.last()[0], 65535);
    SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);  // only the gamepad needs it now
    opened = Error{ErrorKind::device, "closed"};
    EXPECT_TRUE(closed_in_time);
    EXPECT_EQ(again.last()[0], 0) << "it is closed";
}

/// However long its thread is not run: states are waited for.
TEST_F(RumblingGamepad, FollowsTicks) {
    const VirtualGamepad one(told_);
    ASSERT_TRUE(one.is_there()) << SDL_GetError();
    const auto comes_to = [&](const std::function<bool()>& is_so, const HeardTick* tick,
                              GamepadRumble& rumble) {
        for (int k = 0; k < 20'000; ++k) {
            if (is_so()) return true;
            if (tick) rumble.consume(*tick);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return false;
    };
    const HeardTick rough = touching(3, 0.2F, 0.2F), nothing{};
    {
        GamepadRumble rumble;
        const auto turns = [&] { return told_.last()[0] > 0 && told_.last()[1] > 0; };
        const auto stands = [&] { return told_.last() == std::array<std::uint16_t, 2>{0, 0}; };
        ASSERT_TRUE(comes_to(turns, &rough, rumble)) << rumble.state();
        EXPECT_NE(rumble.state().find("rumble: "), std::string::npos);
        EXPECT_TRUE(comes_to(stands, &nothing, rumble)) << "nothing is felt";
        ASSERT_TRUE(comes_to(turns, &rough, rumble));
        EXPECT_TRUE(comes_to(stands, nullptr, rumble)) << "ticks have stopped";
        ASSERT_TRUE(comes_to(turns, &rough, rumble));
    }
    EXPECT_EQ(told_.last(), (std::array<std::uint16_t, 2>{0, 0})) << "the window has closed";
}

#endif

TEST(GamepadRumble, ReportsMissingGamepad) {
    GamepadRumble rumble([]() -> Result<std::unique_ptr<Gamepad>> {
        return Error{ErrorKind::device, "built without it"};
    });
    for (int k = 0; k < 20'000 && rumble.state() != "no rumble: built without it"; ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(rumble.state(), "no rumble: built without it");
    rumble.consume(touching(1));
}

}  // namespace
}  // namespace touchable::test
