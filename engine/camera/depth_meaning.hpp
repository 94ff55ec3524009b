#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/camera/v4l2_stream.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What a camera's depth means, and as its remarks what was assumed.
struct DepthMeaning {
    Scene scene;  ///< far plane and all, but for the rate
    UnstatedFilters unstated_filters{};
    std::vector<std::filesystem::path> inputs{};  ///< files that were read for it
};

/// By what is known of the camera, and by its first pictures, of 16 bits in host order: as guess_scene, but
/// that Z16 is millimetres unless somebody knows better. The far plane is well behind what they show, for
/// what is not seen yet. Errors begin with the node.
Result<DepthMeaning> meaning_of_depth(const NodeFacts& facts, std::uint32_t format,
                                      std::span<const PlaneView> first, const SourceDescription& known);

/// By a scene file, whose size is that of the pictures.
Result<DepthMeaning> meaning_in_file(const NodeFacts& facts, std::span<const PlaneView> first,
                                     const std::filesystem::path& scene_file);

}  // namespace touchable
