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

/// Finds what a camera's depth means, all but the rate; remarks of the scene tell what was assumed. By a
/// scene file, whose size must be that of the pictures; or like guess_camera by `known` and the first
/// frames' depth, of 16 bits in host order, with Z16 in millimetres unless `known` states another unit. An
/// unstated far plane is set well behind what they show. Errors begin with the node, or the file.
Result<LiveReader::Meaning> meaning_of_depth(const NodeFacts& facts, std::uint32_t format,
                                             std::span<const RawFrame> first, const SourceDescription& known,
                                             const std::optional<std::filesystem::path>& scene_file);

}  // namespace touchable
