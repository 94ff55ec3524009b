#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/formats/guessed_scene.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What a recording of ROS 1 says of itself (camera, unit, times), and guesses for the rest.
Result<GuessedScene> guess_bag(const SourceFile& file, const SourceDescription& known);

/// Its depth and colour as a clip: as `described`, otherwise as it is guessed.
Result<std::unique_ptr<ClipReader>> open_bag_clip(const SourceFile& file,
                                                  const std::optional<SceneDescription>& described,
                                                  const SourceDescription& known,
                                                  Colour colour = Colour::wanted);

}  // namespace touchable
