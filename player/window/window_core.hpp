// SPDX-License-Identifier: Apache-2.0
#pragma once

// The core of a window: owns its state, its parts and its modes, dispatches events and commands through the
// modes, and puts another clip in place of the current one.
//
// WindowLoop (window_loop.cpp) owns the core. Each turn it draws, if a picture is due; waits for input;
// handles the events, and those of a script; calls the modes' `tick`; takes the panel's commands; continues
// modes, input and clips; and reports files written or failed.
//
// All of this runs on the window's thread. The screen's own thread calls only WindowHand::stop_at_once; clips
// are opened on a thread of WindowClips.

#include "player/window/window_clips.hpp"
#include "player/window/window_hand.hpp"
#include "player/window/window_input.hpp"
#include "player/window/window_modes.hpp"
#include "player/window/window_panel.hpp"
#include "player/window/window_picture.hpp"
#include "player/window/window_state.hpp"

namespace touchable {

class WindowCore : NonCopyable {
public:
    explicit WindowCore(PlayOptions wanted) : state(std::move(wanted)) {
        state.modes = {&playlist, &measure, &view, &brush};
    }
    /// On every exit path the hand is unpowered before anything is waited for.
    ~WindowCore() { hand.power_off(); }

    /// Opens all parts, once, and requests the first clip. Call it before everything else.
    Result<void> open();

    void take(const InputEvent& event);
    void take(const WindowCommand& command);
    /// Leaves the frontmost item; if there is none, the window.
    void leave();
    /// Once a turn: takes the clip or the change that WindowClips has ready. Fails if the window has to
    /// close.
    Result<void> go_on_with_clips();

    // Destroyed in the opposite order; the screen's thread, which calls the hand, ends with the state.
    WindowHand hand{state};
    WindowState state;
    WindowPanel panel;
    WindowInput input{state, panel};
    WindowClips clips{state};
    WindowPicture picture{state, panel, input, clips};
    PlaylistMode playlist{state, panel, input, clips};
    MeasureMode measure{state, input};
    ViewMode view{state, input};
    BrushMode brush{state, panel, clips, picture.surface()};

private:
    Result<void> open_mode();
    Result<void> open_screen(const KeptSettings& kept);
    Result<void> take_ready(WindowClips::Ready ready);
    Result<void> show(WindowClips::Ready& ready);

    std::unique_ptr<WindowMode> kiosk_;  // or a study; null: neither
};

}  // namespace touchable
