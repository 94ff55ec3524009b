#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/authoring/difference_of_gaussians.hpp"

namespace touchable {

/// What a clip's relief is like, in the numbers of ReliefFilter.
struct ReliefRange {
    std::int32_t full =
        1;  ///< 99 % of what counts is no higher and no deeper: this becomes the largest height
    /// Standard deviation from frame to frame of what does not move. Nothing: no two frames followed each
    /// other.
    std::optional<std::int32_t> noise{};
};

/// Looks at the relief of some frames. Percentiles of the whole clip, not of each frame: otherwise a picture
/// that gets darker would pulse under a resting finger.
class ReliefEstimator {
public:
    /// A frame's relief; `follows` the one that was added before it.
    void add(const NumberField& relief, const NumberField& confidence, bool follows);
    /// Nothing to be felt in any frame: full is 1.
    ReliefRange range() const;

private:
    static constexpr std::size_t most = std::size_t{1} << 16;

    std::vector<std::int64_t> sizes_ = std::vector<std::int64_t>(most), changes_ = sizes_;
    NumberField before_;
};

}  // namespace touchable
