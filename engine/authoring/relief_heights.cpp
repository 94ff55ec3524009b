#include "engine/authoring/relief_heights.hpp"

#include <algorithm>
#include <cstdlib>

namespace touchable {
namespace {

constexpr std::int32_t per_code = 256, level = 128 * per_code, top = 255 * per_code;
/// Of a change that is noise this part is taken on with each frame.
constexpr std::int32_t slowness = 8;
/// A code is left where the height is so far from it: half a code would have it flicker between two.
constexpr std::int32_t stays_within = 3 * per_code / 4;

}  // namespace

const std::vector<std::uint8_t>& ReliefHeights::next(const NumberField& relief) {
    const auto target = [&](std::int32_t number) {
        const std::int64_t height =
            std::int64_t{number} * amount_ * (127 * per_code) / (std::int64_t{100} * range_.full);
        return static_cast<std::int32_t>(std::clamp<std::int64_t>(level + height, 0, top));
    };
    const std::int32_t gate = static_cast<std::int32_t>(
        std::min<std::int64_t>(std::int64_t{3} * range_.noise.value_or(0) * amount_ * (127 * per_code) /
                                   (std::int64_t{100} * range_.full),
                               top));
    const bool begins = states_.size() != relief.numbers.size();
    states_.resize(relief.numbers.size());
    codes_.resize(relief.numbers.size());
    for (std::size_t k = 0; k < states_.size(); ++k) {
        const std::int32_t wanted = target(relief.numbers[k]);
        std::int32_t& state = states_[k];
        const std::int32_t change = wanted - state, size = std::abs(change);
        if (begins || size >= 2 * gate)
            state = wanted;
        else if (size <= gate)
            state += change / slowness;
        else  // from one to the other without a jump
            state +=
                static_cast<std::int32_t>(std::int64_t{change} * ((size - gate) * (slowness - 1) + gate) /
                                          (std::int64_t{gate} * slowness));
        const std::uint8_t before = codes_[k];
        if (begins || std::abs(state - before * per_code) > stays_within)
            codes_[k] = static_cast<std::uint8_t>((state + per_code / 2) / per_code);
        if (begins || size > gate) continue;
        const int by = std::abs(codes_[k] - before);
        ++still_;
        changes_ += by;
        larger_ += by > 1 ? 1 : 0;
    }
    return codes_;
}

std::optional<ReliefHeights::Flicker> ReliefHeights::flicker() const {
    if (still_ == 0) return std::nullopt;
    const auto still = static_cast<double>(still_);
    return Flicker{static_cast<double>(changes_) / still, static_cast<double>(larger_) / still};
}

}  // namespace touchable
