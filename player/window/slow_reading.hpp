#pragma once

#include <cstdint>

#include "player/session/watched_session.hpp"

namespace touchable {

/// Whether frames of a clip come late because reading them takes so long.
class SlowReading {
public:
    /// How the clip is doing; asked for again and again. `period_ms`: from one of its frames to the next.
    void add(const WatchedFigures& figures, double period_ms);

    /// From when on 16 frames and a quarter of all were late or left out, while reading one took longer on
    /// average than building one, and half of its time or more.
    bool is_why() const { return is_why_; }
    /// Of a frame, on average.
    double read_ms() const { return looks_ > 0 ? read_ms_ / static_cast<double>(looks_) : 0; }

private:
    std::int64_t frames_ = 0, looks_ = 0;
    double read_ms_ = 0, build_ms_ = 0;  // sums
    bool is_why_ = false;
};

}  // namespace touchable
