#pragma once

#include <functional>
#include <string>
#include <utility>

#include "device/hand_control.hpp"
#include "player/run/progress.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// What a person sees on a terminal while a live session runs: for how long it has, what came late so far,
/// and the largest force on a finger now. With a device that a person holds, the force that is asked of it,
/// and why it is kept back where it is.
class LiveLine final : public TouchSink {
public:
    /// `control`: of the device that exerts forces on a person, which outlives this; nullptr: none does.
    /// `device`: what is to be said of it; nothing: nothing.
    explicit LiveLine(const HandControl* control = nullptr, std::function<std::string()> device = {})
        : control_(control), device_(std::move(device)) {}
    Result<void> take(const TouchTick& tick) override;
    void show(const LiveStatus& status);

private:
    const HandControl* const control_;
    const std::function<std::string()> device_;
    StatusLine line_;
    std::int64_t ticks_ = 0, next_ = 0;  // taken; the tick after the newest
    double newtons_ = 0;
    bool is_kept_back_ = false;  // a finger's force, until it has been free
    bool is_stale_ = false;      // the surface
};

}  // namespace touchable
