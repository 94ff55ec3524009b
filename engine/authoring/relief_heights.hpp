#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/authoring/relief_estimator.hpp"

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

    /// How far codes change from frame to frame where no more than noise changed: the mean, and the share of
    /// such pixels that change by more than one.
    struct Flicker {
        double mean = 0, more_than_one = 0;
    };
    /// Nothing where nothing stood still from one frame to the next.
    std::optional<Flicker> flicker() const;

private:
    const ReliefRange range_;
    const int amount_;
    std::vector<std::int32_t> states_;  // 256ths of a code
    std::vector<std::uint8_t> codes_;
    std::int64_t still_ = 0, changes_ = 0, larger_ = 0;
};

}  // namespace touchable
