#include "capi/scene_text.hpp"

#include <utility>

#include "engine/base/try.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::capi {

Result<SceneDescription> scene_of_text(std::string_view text) {
    TRY_ASSIGN(auto described, parse_scene(text, "the scene's text"));
    TRY_ASSIGN(auto settled, settle(described, {}));
    SceneDescription whole(std::move(settled));
    whole.unstated.filters = described.unstated.filters;
    return whole;
}

}  // namespace touchable::capi
