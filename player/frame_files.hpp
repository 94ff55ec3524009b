#pragma once

#include <array>
#include <filesystem>

#include "engine/frame/raw_frame.hpp"
#include "engine/frame/surface_frame.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Every file `write_frame_files` may write.
inline constexpr std::array<const char*, 9> frame_file_names{"colour.png", "depth.png", "codes.png",
                                                             "codes.json", "valid.png", "haptic.png",
                                                             "height.png", "mesh.ply",  "scene.json"};

/// Writes one frame, raw and built, into an existing folder. `surface` holds codes (not lazy) of `raw`.
Result<void> write_frame_files(const std::filesystem::path& folder, const RawFrame& raw,
                               const SurfaceFrame& surface, const Scene& scene, bool with_mesh);

}  // namespace touchable
