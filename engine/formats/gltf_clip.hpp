#pragma once

#include <memory>
#include <optional>

#include "engine/base/given_file.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// Whether a file is glTF, by its name (.gltf, .glb) or its first bytes.
bool is_gltf(const SourceFile& file);

/// A touchable clip that a glTF scene describes (docs/mpeg4.md): its planes are textures, tracks of one MP4
/// file or pictures, in the scene's folder or below; nothing is fetched. What they mean stands in "extras" of
/// its mesh. Without that, near and far plane and the camera are assumed, and said. `described` stands in
/// place of all that. Refused where no texture is depth.
Result<std::unique_ptr<ClipReader>> open_gltf_clip(const SourceFile& file,
                                                   const std::optional<SceneDescription>& described,
                                                   Colour colour = Colour::wanted);

}  // namespace touchable
