// SPDX-License-Identifier: Apache-2.0
#include "player/audio/window_sound.hpp"

#ifdef TOUCHABLE_HAS_SDL2

#define SDL_MAIN_HANDLED
#include <SDL.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <set>
#include <string>

namespace touchable {
namespace {

struct Released {
    void operator()(SDL_GameController* pad) const { SDL_GameControllerClose(pad); }
};

class SdlGamepad final : public Gamepad {
public:
    ~SdlGamepad() override {
        rumble({}, 0);
        pad_.reset();
        SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
        SDL_TLSCleanup();  // SDL's data of a thread that it did not start
    }

    std::string look() override {
        SDL_GameControllerUpdate();
        SDL_FlushEvents(SDL_FIRSTEVENT, SDL_LASTEVENT);  // its sticks and buttons are not used
        if (pad_ && SDL_GameControllerGetAttached(pad_.get()) != SDL_TRUE) pad_.reset();
        for (int k = 0; !pad_ && k < SDL_NumJoysticks(); ++k) {
            const SDL_JoystickID id = SDL_JoystickGetDeviceInstanceID(k);
            if (SDL_IsGameController(k) != SDL_TRUE || without_rumble_.contains(id)) continue;
            pad_.reset(SDL_GameControllerOpen(k));
            if (pad_ && SDL_GameControllerHasRumble(pad_.get()) != SDL_TRUE) pad_.reset();
            if (!pad_) without_rumble_.insert(id);  // a reconnected gamepad has a new id
        }
        const char* const name = pad_ ? SDL_GameControllerName(pad_.get()) : "";
        return name ? name : "gamepad";
    }

    void rumble(const Rumble& rumble, int milliseconds) override {
        const auto motor = [](float share) { return static_cast<std::uint16_t>(std::lround(share * 65535)); };
        if (pad_)
            SDL_GameControllerRumble(pad_.get(), motor(rumble.low), motor(rumble.high),
                                     static_cast<std::uint32_t>(milliseconds));
    }

private:
    std::unique_ptr<SDL_GameController, Released> pad_;
    std::set<SDL_JoystickID> without_rumble_;
};

}  // namespace

Result<std::unique_ptr<Gamepad>> Gamepad::open() {
    SDL_SetMainReady();
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");  // the program handles Ctrl-C
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
    if (SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) != 0) return device_error(SDL_GetError());
    return std::make_unique<SdlGamepad>();
}

}  // namespace touchable

#else

namespace touchable {

Result<std::unique_ptr<Gamepad>> Gamepad::open() {
    return device_error("built without it (SDL2: libsdl2-dev)");
}

}  // namespace touchable

#endif
