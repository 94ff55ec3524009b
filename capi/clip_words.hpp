#pragma once

#include <string>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::capi {

/// An error's line with the members of touch_clip_settings that would help.
Error with_members(const Error& error);
/// What a person should know of a clip, with the members that say otherwise.
std::string note_with_members(const Remark& remark);

}  // namespace touchable::capi
