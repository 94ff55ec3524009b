#pragma once

#include <memory>

#include "haptics_cpu/haptic_port.hpp"
#include "player/run/live_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// What a live session's haptic thread is plugged into: the hand, the device that it holds, or the one that a
/// person holds. Opens the device. `setup` outlives the port.
Result<std::unique_ptr<HapticPort>> open_port(TouchSetup& setup);

/// After a session: why its device stopped, it knows best.
void explain_failure(const TouchSetup& setup, LiveFacts& facts);

}  // namespace touchable
