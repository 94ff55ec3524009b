#pragma once

#include <cstdint>

#include "engine/scene/surface_timeline.hpp"

namespace touchable {

/// How many of a clip's frames were seen while they were the clip's.
class FramesShown {
public:
    /// A picture of `pair` is on the screen at `now_ns` of the clip's clock, whose frames are `period_ns`
    /// apart. Frames of the same epoch since the last picture's were not seen. The first of an epoch does not
    /// count: it is waited for.
    void add(const FramePair& pair, std::int64_t now_ns, std::int64_t period_ns);

    /// Another session comes, whose epochs say nothing of those before.
    void forget() { number_ = -1; }

    std::int64_t due() const { return due_; }
    /// Those that were on the screen before the next one was due there.
    std::int64_t in_time() const { return in_time_; }

private:
    std::int64_t due_ = 0, in_time_ = 0;
    std::uint64_t epoch_ = 0;
    std::int64_t number_ = -1;
};

}  // namespace touchable
