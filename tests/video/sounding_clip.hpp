#pragma once

#include <filesystem>
#include <span>
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

/// A film of one grey picture with this sound, as long as it: AAC in MP4, FLAC in Matroska.
void write_sounding_film(const std::filesystem::path& file, const std::vector<StereoSample>& sound);

/// So many samples from one on.
std::vector<StereoSample> heard_in(SoundTrack& track, std::int64_t from, std::size_t count);

/// The largest difference of their left channels, without the first and the last samples.
double largest_difference(std::span<const StereoSample> heard, std::span<const StereoSample> wanted,
                          std::size_t without_first, std::size_t without_last);

struct SeenPicture {
    double seconds = 0;
    int width = 0, height = 0;
    std::vector<int> luma;  ///< 16 is black, rows one after the other
    int at(int x, int y) const { return luma[static_cast<std::size_t>(y * width + x)]; }
};

/// Empty where it cannot be opened or decoded.
std::vector<SeenPicture> seen_in_film(const std::filesystem::path& file);

}  // namespace touchable::test
