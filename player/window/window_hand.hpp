#pragma once

#include <memory>
#include <mutex>

#include "player/window/opened_clip.hpp"

namespace touchable {

class WindowCore;

/// What gives forces in a window, a held device or the pointer's finger, and the ways to stop them: the force
/// key at once, by the screen's thread; the window's end, before anything is waited for. By the window's
/// thread, but for `stop_at_once`.
class WindowHand {
public:
    explicit WindowHand(WindowCore& core) : core_(core) {}

    /// Takes the power of a held device off, for good, as the window ends. Forces are no longer asked for,
    /// too, so that the session's last ticks are recorded as the hand had them.
    void power_off();
    /// The force key takes forces off while the main thread draws or waits. One that comes where forces are
    /// off asks for them, which is the main thread's. By the screen's thread.
    void stop_at_once(InputEvent& event);
    /// From now on stop_at_once stops the newest session of the clip. A key that came between that session's
    /// begin and this call has stopped the session before; the main thread then stops this one, as for every
    /// key.
    void lead();

    /// Once a turn, of a held device: says why it went. (HandControl switches forces off after a second
    /// without a user.)
    void look_after();
    /// The force key: forces off, or on again if `may_turn_on`.
    void turn_force(bool may_turn_on);
    /// How far fingers go with a held device: a setting like the others, by steps.
    void change_scale(double times);

private:
    WindowCore& core_;
    std::mutex mutex_;
    // What gives forces now, guarded by it. The screen's thread stops them too; it ends before this does.
    std::shared_ptr<PointerDevice> pointer_;
    std::shared_ptr<HandControl> control_;  // null: the pointer leads
    bool is_gone_ = false;
};

}  // namespace touchable
