#pragma once

#include <filesystem>
#include <string_view>

#include "engine/import/touch_maps/haptic_layers.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The first material of MPEG_haptic_material with stiffness or friction in a glTF file (.gltf, or .glb) of
/// these bytes. The extension has no units: black and white are the ends of the scene's haptic ranges, or of
/// "extras": {"touchable_range": [black, white]} beside a texture, in N/mm for stiffness. A property without
/// a texture is as in the scene's default_properties.
Result<HapticLayers> read_gltf_material(const std::filesystem::path& file, std::string_view bytes,
                                        const Scene& scene);

}  // namespace touchable
