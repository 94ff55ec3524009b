#pragma once

#include <string>

#include "engine/camera/video_system.hpp"

namespace touchable {

/// For a person: each camera that is plugged in, what it offers, the command that touches it, and what is
/// missing where it cannot be touched. Lines; with no camera one, which says what to do.
std::string cameras_in_words(VideoSystem& system);

}  // namespace touchable
