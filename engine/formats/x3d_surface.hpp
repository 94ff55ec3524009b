#pragma once

#include <filesystem>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/formats/haptic_layers.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The first HapticTexturesSurface (H3DAPI) with maps in an X3D file in XML, whose text this is. Stiffness in
/// N/m, or relative: then 1 is the upper end of the scene's haptic.stiffness. Fields that are left out have
/// H3DAPI's defaults. Textures are DEF'd anywhere in the file; the first of their URLs that leads to a file
/// here counts.
Result<HapticLayers> read_x3d_surface(const std::filesystem::path& file, std::string_view text,
                                      const Scene& scene);

}  // namespace touchable
