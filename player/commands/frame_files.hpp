#pragma once

#include <array>

#include "engine/frame/raw_frame.hpp"
#include "engine/frame/surface_frame.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"
#include "player/commands/staged_folder.hpp"

namespace touchable {

/// Every file `write_frame_files` may write.
inline constexpr std::array<const char*, 9> frame_file_names{"colour.png", "depth.png", "codes.png",
                                                             "codes.json", "valid.png", "haptic.png",
                                                             "height.png", "mesh.ply",  "scene.json"};

/// Writes one frame, raw and built, for `folder`, which is not committed. `surface` holds codes (not lazy) of
/// `raw`.
Result<void> write_frame_files(StagedFolder& folder, const RawFrame& raw, const SurfaceFrame& surface,
                               const Scene& scene, bool with_mesh);

}  // namespace touchable
