#include "capi/scene_text.hpp"

#include <utility>

#include "engine/scene/scene_file.hpp"

namespace touchable::capi {

Result<SceneDescription> scene_of_text(std::string_view text) {
    auto described = parse_scene(text, "the scene's text");
    if (!described) return described.error();
    auto settled = settle(*described, {});
    if (!settled) return settled.error();
    SceneDescription whole(std::move(*settled));
    whole.unstated.filters = described->unstated.filters;
    return whole;
}

}  // namespace touchable::capi
