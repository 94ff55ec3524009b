#pragma once

#include <filesystem>
#include <vector>

#include "engine/picture/sound.hpp"

namespace touchable::test {

/// Writes `pictures` again, if any, with a track of this sound, stored as floats at `rate`. Sound and
/// pictures are so many milliseconds later than the file's begin.
void write_sounding_clip(const std::filesystem::path& file, const std::vector<StereoSample>& sound,
                         const std::filesystem::path& pictures = {}, int rate = SoundTrack::rate,
                         int sound_later_ms = 0, int pictures_later_ms = 0);

/// A sine of so many hertz.
std::vector<StereoSample> tone(double hertz, double seconds, int rate = SoundTrack::rate);

}  // namespace touchable::test
