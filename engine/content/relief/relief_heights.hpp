#pragma once

#include <cstdint>
#include <vector>

#include "engine/content/relief/relief_estimator.hpp"

namespace touchable {

/// Height codes of 8 bits of a clip's relief, frame after frame: 128 is level. What may be noise of the
/// camera is averaged, and a code stays until another is clearly nearer, so that a still point feels still.
class ReliefHeights {
public:
    /// `amount`: per cent of the largest height that the range's `full` becomes.
    ReliefHeights(const ReliefRange& range, int amount) : range_(range), amount_(amount) {}

    /// Of the next frame; until the next call.
    const std::vector<std::uint8_t>& next(const NumberField& relief);
    /// The next frame is not what follows the one before.
    void forget() { states_.clear(); }

private:
    const ReliefRange range_;
    const int amount_;
    std::vector<std::int32_t> states_;  // 256ths of a code
    std::vector<std::uint8_t> codes_;
};

}  // namespace touchable
