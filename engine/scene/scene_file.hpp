#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

inline constexpr int scene_format_version = 1;

/// Reads and validates a scene description (JSON, docs/scene_file.md). `where` names the text in messages.
/// A newer format version, an unknown member or an impossible number is refused by name.
Result<Scene> parse_scene(std::string_view json, std::string_view where);
Result<Scene> read_scene_file(const std::filesystem::path& file);

/// The same description as text; parse_scene gives back the same scene, every double to its last bit.
/// (Of a remark what says otherwise is not kept.)
std::string scene_to_json(const Scene& scene);

}  // namespace touchable
