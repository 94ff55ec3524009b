#pragma once

#include "engine/formats/guessed_scene.hpp"

namespace touchable {

/// Of a video without a scene file, by its first picture: LeRobot's depth (lerobot_video.hpp); Record3D's
/// export (hue on the left, its camera at the file's end); a half that is grey beside one that is not; grey
/// everywhere; one map of hues everywhere. Camera and unit as for a picture. An error says what was seen, and
/// what would open it.
Result<GuessedScene> guess_video(const SourceFile& file, const SourceDescription& known);

}  // namespace touchable
