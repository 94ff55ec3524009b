#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// --filters, all at once instead of the scene's own: as typed.
CLI::Option* add_filters_option(CLI::App& sub, std::optional<std::string>& typed);

/// auto, off, or those that shall be on: `median[=3|5]`, `holes[=PASSES]`, `terraces`, `temporal[=C[+Q]]`,
/// `flying=C[+Q]`,
/// with commas between. Refused (ErrorKind::usage) where it is none of these.
Result<FiltersChoice> read_filters(const std::string& typed);

}  // namespace touchable
