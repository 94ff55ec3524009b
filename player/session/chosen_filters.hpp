#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/scene/scene_description.hpp"
#include "engine/surface/depth_estimator.hpp"

namespace touchable {

/// What the first frames say of a clip.
struct MeasuredFrames {
    std::optional<MeasuredDepth> depth;  ///< nothing: no pixel is valid
    std::string damage;                  ///< why they ended early; empty: they did not
};
/// Needs a reader at the beginning, and leaves one that is there again. An error of kind interrupted once it
/// was `given_up`.
Result<MeasuredFrames> measure_depth(std::unique_ptr<ClipReader>& reader, const Scene& scene,
                                     const std::stop_token& given_up = {});

/// Filters that were chosen by what was measured.
struct ChosenFilters {
    UnstatedFilters chosen;                 ///< which of them; the others are what the scene states
    std::optional<MeasuredDepth> measured;  ///< nothing: no pixel is valid
    std::string damage{};                   ///< as MeasuredFrames has it
};
/// Settles in the scene what is unstated (choose_filters), and levels that terrace removal needs. Nothing
/// where nothing is open: then no frame is read. `known`: what the frames said when they were measured
/// before; nothing: nobody has.
Result<std::optional<ChosenFilters>> settle_filters(std::unique_ptr<ClipReader>& reader,
                                                    const UnstatedFilters& unstated, Scene& scene,
                                                    const std::optional<MeasuredFrames>& known = {},
                                                    const std::stop_token& given_up = {});

}  // namespace touchable
