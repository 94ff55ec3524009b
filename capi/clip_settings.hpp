#pragma once

#include <optional>

#include "capi/touchable.h"
#include "engine/base/result.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable::capi {

/// What stands where a program sets nothing: colour, and nothing known of the camera.
touch_clip_settings default_clip_settings();

/// What a program says of a clip's camera; nothing where it says nothing. Errors name the member.
Result<std::optional<SourceDescription>> known_of(const touch_clip_settings& settings);

}  // namespace touchable::capi
