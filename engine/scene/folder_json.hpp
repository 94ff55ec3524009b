#pragma once

#include <nlohmann/json.hpp>

#include "engine/scene/checked_json.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The member `folder` of a scene file: a plane is a name, or an object of `files`, `first` and `step`.
/// Throws `checked_json::Refusal`.
FolderSource read_folder(const checked_json::Node& node);
nlohmann::ordered_json write_folder(const FolderSource& folder);

}  // namespace touchable
