// SPDX-License-Identifier: Apache-2.0
#include "bench/stream/felt_stream.hpp"

#include <algorithm>
#include <glm/geometric.hpp>

namespace touchable {

Result<void> FeltStream::consume(const TouchTick& tick) {
    if (tick.pair.prev.number > newest_) {
        newest_ = tick.pair.prev.number;
        since_tick_ = tick.tick;
    }
    longest_hold_ms_ = std::max(longest_hold_ms_, static_cast<double>(tick.tick - since_tick_));
    const bool follows = tick.tick == last_tick_ + 1;  // a skipped tick changes more
    last_tick_ = tick.tick;
    const std::size_t fingers = tick.forces.size();
    before_.last.resize(fingers);
    after_.last.resize(fingers);
    const auto step = [&](Steps& steps, std::size_t finger, const glm::dvec3& force) {
        if (follows) steps.largest = std::max(steps.largest, glm::length(force - steps.last[finger]));
        steps.last[finger] = force;
    };
    for (std::size_t k = 0; k < fingers; ++k) {
        step(before_, k, tick.contacts[k].force);
        step(after_, k, tick.sent(k));
    }
    return {};
}

}  // namespace touchable
