#pragma once

// The scene file (docs/scene_file.md): JSON that says what a clip means, in and out.
//
// read_scene_file and parse_scene take a text from outside: each member is checked, an error names it and
// says what would be right. scene_to_json gives a text that is read as the same scene. Functions keep no
// state.

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

inline constexpr int scene_format_version = 1;

/// Reads and validates a scene description (JSON, docs/scene_file.md). `where` names the text in messages.
/// A newer format version, an unknown member or an impossible number is refused by name.
Result<SceneDescription> parse_scene(std::string_view json, std::string_view where);
Result<SceneDescription> read_scene_file(const std::filesystem::path& file);

/// The same description as text; parse_scene gives back the same, every double to its last bit. (Of a remark
/// what says otherwise is not kept.) What it leaves open stays open.
std::string scene_to_json(const SceneDescription& described);

}  // namespace touchable
