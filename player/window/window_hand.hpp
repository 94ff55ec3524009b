// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>

#include "player/window/opened_clip.hpp"

namespace touchable {

class WindowState;

/// The window's source of forces, a haptic device or the pointer's finger, and the ways to stop them: the
/// force key at once, on the screen's thread; and the window's end, before anything is waited for. The
/// window's thread only, except `stop_at_once`.
class WindowHand {
public:
    explicit WindowHand(WindowState& window) : window_(window) {}

    /// Powers the haptic device down permanently, as the window ends. Also withdraws the request for forces,
    /// so that the session's last ticks are recorded as felt.
    void power_off();
    /// Lets the force key switch forces off while the main thread draws or waits. If forces are off, the key
    /// requests them, on the main thread. Called on the screen's thread.
    void stop_at_once(InputEvent& event);
    /// Makes stop_at_once stop the clip's newest session. A key between that session's begin and this call
    /// has stopped the previous session; the main thread then stops this one, as for every key.
    void lead();

    /// Once a turn, with a haptic device: reports why it failed. (HandControl switches forces off after a
    /// second without a user.)
    void look_after();
    /// The force key: forces off, or on again if `may_turn_on`.
    void turn_force(bool may_turn_on);

private:
    WindowState& window_;
    std::mutex mutex_;
    // The current source of forces, guarded by mutex_; the screen's thread, which ends first, stops it too.
    std::shared_ptr<PointerDevice> pointer_;
    std::shared_ptr<HandControl> control_;  // null: the pointer leads
    bool is_gone_ = false;
};

}  // namespace touchable
