#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "engine/media/clip.hpp"

namespace touchable {

/// A touchable Matroska clip; `scene` replaces the one attached to it.
Result<std::unique_ptr<ClipReader>> open_matroska_clip(const std::filesystem::path& file,
                                                       const std::optional<Scene>& scene,
                                                       Colour colour = Colour::wanted);

}  // namespace touchable
