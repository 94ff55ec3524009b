#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/mpeg4/scene_tree.hpp"

namespace touchable::mpeg4 {

/// How a stream of BIFS is to be read, as its decoder is told before it (BIFSConfig, BIFSv2Config).
struct BifsConfig {
    int version = 2;  ///< 1 has no prototypes
    int node_id_bits = 1, route_id_bits = 0, prototype_id_bits = 0;
    int width = 0, height = 0;  ///< of the picture, pixels; 0: not said
    /// What MPEG-4 calls such a stream (objectTypeIndication).
    std::uint8_t object_type() const { return version == 1 ? 1 : 2; }
};
/// The least that this scene needs.
BifsConfig config_for(const SceneTree& scene, int width, int height);
std::vector<std::uint8_t> encode_config(const BifsConfig& config);
/// `object_type`: 1 or 2.
Result<BifsConfig> decode_config(std::span<const std::uint8_t> bytes, int object_type);

/// A scene as one access unit that begins it anew (SceneReplace), with the names of nodes, prototypes and
/// fields. An error where a node has no binary form, such as the paper's own, or stands where it cannot.
Result<std::vector<std::uint8_t>> encode_scene(const SceneTree& scene, const BifsConfig& config);
/// Bytes behind it say nothing. Errors name the bit at which they were met.
Result<SceneTree> decode_scene(std::span<const std::uint8_t> bytes, const BifsConfig& config);

}  // namespace touchable::mpeg4
