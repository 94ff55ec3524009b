#pragma once

#include <filesystem>

#include "engine/picture/ffmpeg_input.hpp"

namespace touchable {

/// A file of a kind that may have sound: Matroska, QuickTime and MP4, WAV. Null where it is of another, or is
/// no ordinary file.
InputPtr open_sound_container(const std::filesystem::path& file);

/// Seconds at which the clip's first frame is shown, which is when its sound begins to count: 0 where there
/// is none near the file's begin. Goes on through the file.
double begin_of_pictures(AVFormatContext& container, AVPacket& packet);

}  // namespace touchable
