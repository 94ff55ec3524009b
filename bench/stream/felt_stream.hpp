// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "player/run/touch_session.hpp"

namespace touchable {

/// Figures of touch on a surface received by a network: how long a frame is held until the next arrives, and
/// how forces change from tick to tick, before and after the guard.
class FeltStream final : public TouchSink {
public:
    Result<void> consume(const TouchTick& tick) override;

    double longest_hold_ms() const { return longest_hold_ms_; }
    /// N, any finger: step of the solver's force, jumps included; step of the force sent to the hand.
    double largest_step_before() const { return before_.largest; }
    double largest_step_after() const { return after_.largest; }

private:
    struct Steps {
        std::vector<glm::dvec3> last{};
        double largest = 0;
    };
    std::int64_t newest_ = -1, since_tick_ = 0;
    double longest_hold_ms_ = 0;
    std::int64_t last_tick_ = -1;
    Steps before_, after_;
};

}  // namespace touchable
