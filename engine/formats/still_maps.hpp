#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/still_planes.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Pictures of touch that serve a whole clip, whatever it has itself.
struct StillMaps {
    /// A picture (RGB: stiffness, static and dynamic friction; grey: stiffness), X3D with a
    /// HapticTexturesSurface, or glTF with MPEG_haptic_material.
    std::optional<std::filesystem::path> haptic;
    std::optional<std::filesystem::path> height;  ///< a picture in grey
};

/// Whether a name is that of X3D or glTF rather than of a picture.
bool is_surface_file(const std::filesystem::path& file);

/// Where the file says what its values stand for, or what a scene's defaults are for it, `scene` is changed.
Result<StillPlane> read_haptic_map(const std::filesystem::path& file, Scene& scene);
/// A scene without heights gets some: one level for white.
Result<StillPlane> read_height_map(const std::filesystem::path& file, Scene& scene);

/// The clip with those maps under every frame.
Result<std::unique_ptr<ClipReader>> with_still_maps(Result<std::unique_ptr<ClipReader>> clip,
                                                    const StillMaps& maps);

}  // namespace touchable
