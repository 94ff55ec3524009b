#pragma once

#include <string>

#include "engine/scene/checked_json.hpp"

namespace touchable {

/// A line of text for visitors: not empty, up to 200 bytes of UTF-8, no control characters. Throws
/// checked_json::Refusal.
std::string read_plain_line(const checked_json::Node& node);

/// "de", "pt-BR": two or three small letters, and perhaps a part behind a hyphen. Likewise.
std::string read_language(const checked_json::Node& node);
/// Whether it is one.
bool is_language(const std::string& word);

}  // namespace touchable
