#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

inline constexpr int scene_format_version = 1;

/// Reads and validates a scene description (JSON, docs/scene_file.md). `where` names the text in messages.
/// A newer format version, an unknown member or an impossible number is refused by name.
Result<Scene> parse_scene(std::string_view json, std::string_view where);
Result<Scene> read_scene_file(const std::filesystem::path& file);

/// The same description as text; parse_scene gives back the same scene, every double to its last bit.
/// `remarks` are for people, and parse_scene passes them over.
std::string scene_to_json(const Scene& scene, const std::vector<std::string>& remarks = {});

}  // namespace touchable
