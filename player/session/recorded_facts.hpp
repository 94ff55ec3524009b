#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/result.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// What a recording keeps of a run beside its ticks (docs/recording.md); what it came to is added after it.
nlohmann::ordered_json recorded_facts(const TouchSetup& setup);

/// Fills in what those facts say of the run, but for what is opened and made of it, and gives the scene that
/// was touched. An error of kind input that begins with `name` where something is missing, of another kind or
/// impossible.
Result<Scene> read_recorded_facts(const nlohmann::ordered_json& facts, const std::string& name,
                                  TouchSetup& setup);

}  // namespace touchable
