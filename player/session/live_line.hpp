#pragma once

#include <functional>
#include <string>

#include "player/session/progress.hpp"
#include "player/session/touch_session.hpp"

namespace touchable {

/// What a person sees on a terminal while a live session runs: for how long it has, what came late so far,
/// and the largest force on a finger now.
class LiveLine final : public TouchSink {
public:
    Result<void> take(const TouchTick& tick) override;
    /// How many frames came too late, or what else there is to say of them; and of the device.
    void show(std::int64_t frames, const char* what, const std::function<std::string()>& device);

private:
    StatusLine line_;
    std::int64_t ticks_ = 0, next_ = 0;  // taken; the tick after the newest
    double newtons_ = 0;
};

}  // namespace touchable
