#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// --temporal, instead of the scene's own: as typed.
CLI::Option* add_temporal_option(CLI::App& sub, std::optional<std::string>& typed);

/// The whole of a text; nothing where it is no number.
std::optional<double> as_number(std::string_view text);
/// C, or C and Q with `separator` between.
std::optional<DepthLength> as_depth_length(std::string_view text, char separator);

/// off, on (the noise is the scene's, or measured), or on with this noise: CONSTANT or CONSTANT,QUADRATIC.
/// Refused (ErrorKind::usage) where it is none of these.
Result<TemporalChoice> read_temporal(const std::string& typed);

}  // namespace touchable
