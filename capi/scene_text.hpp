#pragma once

#include <string_view>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::capi {

/// A scene of the text of a scene file, settled; `unstated` lists the filters that the text leaves open.
Result<SceneDescription> scene_of_text(std::string_view text);

}  // namespace touchable::capi
