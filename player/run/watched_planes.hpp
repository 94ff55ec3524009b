#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// Of a frame, as stored, and what keeps it alive.
struct HeldPlanes {
    PlaneView colour;  ///< empty: it has none
    PlaneView depth;
    std::shared_ptr<const void> storage;
};

/// Stored planes of the frames in the timeline, for whoever draws them and looks at them: between the thread
/// that builds and the eye's. Touch knows nothing of it.
class WatchedPlanes {
public:
    /// By the thread that builds: before its frame is published, so that nobody sees one without.
    void put(const RawFrame& raw) {
        if (!raw.storage) return;
        const std::lock_guard lock(mutex_);
        if (!frames_.empty() && frames_.back().epoch == raw.epoch && frames_.back().number == raw.number)
            return;
        frames_.push_back({raw.epoch, raw.number, {raw.colour, raw.depth, raw.storage}});
        if (frames_.size() > most) frames_.pop_front();
    }
    /// By the eye: the planes of this frame, if they are kept. Those of earlier frames are freed, since
    /// nobody asks for them any more.
    std::optional<HeldPlanes> find(std::uint64_t epoch, std::int64_t number) {
        const std::lock_guard lock(mutex_);
        for (std::size_t k = 0; k < frames_.size(); ++k) {
            if (frames_[k].epoch != epoch || frames_[k].number != number) continue;
            frames_.erase(frames_.begin(), frames_.begin() + static_cast<std::ptrdiff_t>(k));
            return frames_.front().planes;
        }
        return std::nullopt;
    }

private:
    static constexpr std::size_t most = 32;  // more than a timeline with an eye has entries
    struct Frame {
        std::uint64_t epoch;
        std::int64_t number;
        HeldPlanes planes;
    };
    std::mutex mutex_;
    std::deque<Frame> frames_;
};

}  // namespace touchable
