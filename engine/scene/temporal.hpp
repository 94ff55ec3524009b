#pragma once

#include <optional>

#include "engine/scene/code_curve.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/working_codes.hpp"

namespace touchable {

/// Frames for which a pixel without depth keeps what it had.
inline constexpr int temporal_hold_frames = 3;
/// Where a clip is not read from its beginning, the filter begins empty so many frames before the first that
/// anybody wants.
inline constexpr int temporal_warm_up_frames = 16;

/// The temporal filter, as it works on one scene's codes; docs/conventions.md has the arithmetic.
struct TemporalFilter {
    WorkingCodes working;  ///< of codes first
    CodeCurve gate;        ///< how far from one frame to the next a code may be off by noise alone
    DepthCoding coding;    ///< of the working codes
    bool operator==(const TemporalFilter&) const = default;
};

/// What the scene asks for; nothing: no filter. Needs a scene that `validate` accepts.
std::optional<TemporalFilter> temporal_filter(const Scene& scene);

}  // namespace touchable
