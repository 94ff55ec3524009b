#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "engine/clip/clip_reader.hpp"
#include "engine/given_file.hpp"

namespace touchable {

/// A touchable Matroska clip; `described` replaces the one attached to it.
Result<std::unique_ptr<ClipReader>> open_matroska_clip(const SourceFile& file,
                                                       const std::optional<SceneDescription>& described,
                                                       Colour colour = Colour::wanted);

}  // namespace touchable
