#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/scene_description.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// What a recording keeps of a run that has ended beside its ticks (docs/recording.md), but for its forces'
/// hash.
nlohmann::ordered_json recorded_facts(const TouchSetup& setup);

/// Of which frames the `planes_hash` of such facts is; nothing where they do not say. Throws
/// std::out_of_range, with the member's name, where what they say cannot be.
std::optional<std::vector<FrameRun>> built_frames(const nlohmann::ordered_json& facts);

/// Fills in what those facts say of the run, but for what is opened and made of it, and gives the scene that
/// was touched. An error of kind input that begins with `name` where something is missing, of another kind or
/// impossible.
Result<SceneDescription> read_recorded_facts(const nlohmann::ordered_json& facts, const std::string& name,
                                             TouchSetup& setup);

}  // namespace touchable
