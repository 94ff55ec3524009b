#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "engine/result.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// --temporal, instead of the scene's own: as typed.
CLI::Option* add_temporal_option(CLI::App& sub, std::optional<std::string>& typed);

/// off, on (the noise is the scene's), or on with this noise: CONSTANT or CONSTANT,QUADRATIC. Refused
/// (ErrorKind::usage) where it is none of these.
Result<TemporalChoice> read_temporal(const std::string& typed);

}  // namespace touchable
