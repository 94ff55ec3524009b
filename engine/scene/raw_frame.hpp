#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/scene/plane_view.hpp"

namespace touchable {

/// The planes of one moment as stored, all of the scene's width and height. Only depth is always there.
struct RawFrame {
    std::int64_t number = 0;   ///< from 0
    std::int64_t time_ns = 0;  ///< presentation timestamp
    PlaneView depth;           ///< 1 channel, stored values; for hue 3 channels, 8 bits
    PlaneView colour;          ///< 3 channels, 8 bits
    PlaneView haptic;          ///< 3 channels, 8 bits: stiffness, static friction, dynamic friction
    PlaneView height;          ///< 1 channel
    /// Keeps the planes alive, and as they are; nothing: they last only as long as a call that is given them.
    std::shared_ptr<const void> storage;
    /// Of the clip's clock (MediaMoment); 0 as a reader gives it. Frames of two epochs are not each other's
    /// neighbours, whatever their numbers.
    std::uint64_t epoch = 0;
    /// Pixels to which other frames of the clip gave their depth (with_filled_holes), as the bits of
    /// SurfaceFrame::validity; null: there are none. It shows where depth was not measured, no more.
    std::shared_ptr<const std::vector<std::uint32_t>> filled;
};

/// The same for whoever keeps it beyond the call that gave it: itself where its storage keeps its planes,
/// otherwise a copy of them.
RawFrame kept_frame(const RawFrame& frame);

/// Which frame it was, for whoever remembers one. Between two of an epoch frames may have been left out.
struct FramePlace {
    std::uint64_t epoch = 0;
    std::int64_t number = 0;

    explicit FramePlace(const RawFrame& raw) : epoch(raw.epoch), number(raw.number) {}
    bool is_before(const RawFrame& raw) const { return epoch == raw.epoch && number < raw.number; }
};

/// True where samples of both can be compared byte by byte, or neither plane is there.
bool same_form(const PlaneView& a, const PlaneView& b);
/// True where both planes have the same form and samples, or neither is there. Stops at the first row that
/// differs; planes at the same place are not compared.
bool same_samples(const PlaneView& a, const PlaneView& b);

/// True where depth, haptic and height planes, all that a surface is made of, have the same form and samples.
/// Stops at the first row that differs.
bool same_touch_planes(const RawFrame& a, const RawFrame& b);

}  // namespace touchable
