#pragma once

#include <functional>
#include <string>

#include "engine/camera/video_system.hpp"

namespace touchable {

/// The lines of a program on how to touch a camera by its name, such as "v4l2:/dev/video0", and by the name
/// with which its colour is seen as well; empty: it has none.
using HowToTouch = std::function<std::string(const std::string& camera, const std::string& with_colour)>;

/// For a person: each camera that is plugged in, what it offers, how it is touched, and what is missing where
/// it cannot be. Lines; with no camera one, which says what to do.
std::string cameras_in_words(VideoSystem& system, const HowToTouch& how);

}  // namespace touchable
