#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "engine/authoring/material_clip.hpp"
#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

struct MaterialsOptions {
    ClipChoice clip;
    std::filesystem::path out;   ///< NAME.mkv, NAME.png; empty: segments are only told
    std::filesystem::path save;  ///< where the segments' names are written; empty: nowhere
    Existing existing = Existing::keep;
    MaterialSettings materials{};             ///< of which `ranges` does not count
    std::optional<std::int64_t> frame;        ///< that is told, or becomes NAME.png; nothing: the first
    std::vector<std::filesystem::path> read;  ///< files that were read for this, beside the clip
};

/// Writes the clip with what its segments feel like, or one frame's haptic picture, or nothing; and tells of
/// the segments, their materials and how steady they are.
Result<void> run_materials(const MaterialsOptions& options);

/// The palette, a line for each material.
Result<void> print_palette();

}  // namespace touchable
