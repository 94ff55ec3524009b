#pragma once

#include <cstdint>

#include "engine/clip/clip_reader.hpp"
#include "player/run/time_spread.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// What became of a camera's frames in a live run.
struct CameraFacts {
    std::int64_t frames_shown = 0;  ///< that fingers felt
    Spread exposure_to_force_ms;    ///< from taking a frame to the first force that it made
};

/// Finds that out tick by tick.
class CameraFigures final : public TouchSink {
public:
    /// `source` outlives it. `first`: of the frames that the run waits for; those before it were there when
    /// it began.
    CameraFigures(const ClipReader& source, std::int64_t first) : source_(source), newest_(first - 1) {}
    Result<void> take(const TouchTick& tick) override;
    std::int64_t frames_shown() const { return shown_; }
    CameraFacts facts() const;

private:
    const ClipReader& source_;
    std::int64_t newest_;  // that was felt
    std::int64_t shown_ = 0;
    TimeSpread latency_ms_;
};

}  // namespace touchable
