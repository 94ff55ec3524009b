#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "player/commands/clip_facts.hpp"

namespace touchable {

nlohmann::ordered_json to_json(const ClipFacts& facts);
/// The same for a person, one fact a line.
std::string to_text(const ClipFacts& facts);

}  // namespace touchable
