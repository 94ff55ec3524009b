#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/authoring/colour_edges.hpp"
#include "engine/authoring/frame_times.hpp"
#include "engine/authoring/haptic_values.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/picture/image_file.hpp"

namespace touchable {

/// What was measured of a whole clip. How each is measured stands with its type.
struct ClipQuality {
    FrameTimes times;
    std::int64_t blank = 0;                  ///< frames without any depth
    std::int64_t first_blank = 0;            ///< number of the first of them
    std::optional<double> pumping;           ///< share of the depth (PumpingEstimator)
    std::optional<ColourEdges::Fit> colour;  ///< nothing: no colour, or too few edges
    std::optional<HapticValues> haptic;      ///< nothing: no haptic picture

    /// In the first frame: pixels that are concerned are 1, row by row.
    struct Where {
        Image picture;  ///< colour, or without it depth as grey, near is bright
        std::vector<std::uint8_t> colour_edges, level_steps;
        HapticValuesEstimator::Where haptic;
    } where;
};

/// Reads all frames of a clip that is at its beginning. `scene`: with the levels of its depth
/// (FilterSettings::levels), where these are known. `progress` is given the number of frames that were read.
/// An error of kind interrupted where the program is asked to stop.
Result<ClipQuality> measure_quality(ClipReader& clip, const Scene& scene,
                                    const std::function<void(std::int64_t)>& progress);

}  // namespace touchable
