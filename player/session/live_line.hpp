#pragma once

#include <functional>
#include <string>

#include "device/hand_control.hpp"
#include "player/session/progress.hpp"
#include "player/session/touch_session.hpp"

namespace touchable {

/// What a person sees on a terminal while a live session runs: for how long it has, what came late so far,
/// and the largest force on a finger now. With a device that a person holds, the force that is asked of it,
/// and why it is kept back where it is.
class LiveLine final : public TouchSink {
public:
    /// `control`: of that device, which outlives this; nullptr: nobody holds one.
    explicit LiveLine(const HandControl* control = nullptr) : control_(control) {}
    Result<void> take(const TouchTick& tick) override;
    /// How many frames came too late, or what else there is to say of them; and of the device.
    void show(std::int64_t frames, const char* what, const std::function<std::string()>& device);

private:
    const HandControl* const control_;
    StatusLine line_;
    std::int64_t ticks_ = 0, next_ = 0;  // taken; the tick after the newest
    double newtons_ = 0;
    bool is_kept_back_ = false;  // a finger's force, until it has been free
};

}  // namespace touchable
