#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/mpeg4/scene_tree.hpp"

namespace touchable::mpeg4 {

/// Reads a scene's text (BT): prototypes, then one node. The paper's own nodes are known without a prototype.
/// Errors begin "line 3, column 5: ".
Result<SceneTree> parse_scene_text(std::string_view text);

/// The text of a scene: as MPEG-4 tools read it, two spaces deeper for each node.
std::string scene_text(const SceneTree& scene);

}  // namespace touchable::mpeg4
