#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// How a camera delivers what it takes. Moments are those of a run, ns.
struct CameraDelivery {
    std::optional<FrameRate> rate{};  ///< nothing: the recording's own
    std::int64_t jitter_ns = 0;       ///< the longest time from exposure to delivery
    double drop = 0;                  ///< the share of frames that never come, 0 to below 1
    std::optional<std::int64_t> stall_ns{},
        resume_ns{};  ///< nothing is delivered between; no end: never again
};

inline constexpr std::int64_t never_delivered = std::numeric_limits<std::int64_t>::max();

/// A frame, and when it is there.
struct Delivery {
    std::int64_t number = -1;
    std::int64_t at_ns = 0;  ///< of the run, or `never_delivered`
};
/// What comes after `last`: the next frame that is not left out, not before its own time n / rate. As random
/// as the settings want it, and the same every time.
Delivery delivery_after(const Delivery& last, const CameraDelivery& settings, const FrameRate& rate);

/// A recording that behaves like a camera. Frame n is taken at time_ns = n / rate and comes when
/// `delivery_after` says. Frames keep the recording's numbers, so that those left out are gaps.
///
/// Until `begin` it is a clip: every frame is there at once. After it `next` waits for the next delivery, and
/// gives the newest frame where several were delivered before it was asked. A frame is decoded while it is
/// waited for. Frames are held and not interpolated, for none of the future exists.
std::unique_ptr<ClipReader> make_replay_camera(std::unique_ptr<ClipReader> recording,
                                               const CameraDelivery& delivery);

}  // namespace touchable
