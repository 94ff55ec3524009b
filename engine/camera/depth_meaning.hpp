#pragma once

// What a camera's depth means, for cameras of any kind.

#include <cstdint>
#include <filesystem>
#include <span>

#include "engine/base/result.hpp"
#include "engine/camera/v4l2_stream.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// What a camera's depth means, all but the rate, and as remarks of the scene what was assumed: by a scene
/// file, whose size is that of the pictures; or by what is known of the camera, and by its first pictures, of
/// 16 bits in host order, as guess_camera, but that Z16 is millimetres unless `known` says otherwise. A far
/// plane that is open is well behind what they show, for what is not seen yet. Errors begin with the node, or
/// the file.
Result<LiveReader::Meaning> meaning_of_depth(const NodeFacts& facts, std::uint32_t format,
                                             std::span<const PlaneView> first, const SourceDescription& known,
                                             const std::optional<std::filesystem::path>& scene_file);

}  // namespace touchable
