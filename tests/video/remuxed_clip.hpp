// SPDX-License-Identifier: Apache-2.0
#pragma once

// Clips written again by FFmpeg alone, with faults or with sound; and films, written and seen.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "engine/picture/sound.hpp"

namespace touchable::test {

/// How a clip is written again, not as this project would: for clips that must be refused.
struct Remux {
    std::map<std::string, std::string> file_tags{};  ///< set; an empty value removes the tag
    std::map<std::string, std::string>
        roles{};  ///< role -> new tag T3D_ROLE; an empty value removes the track
    std::map<std::string, std::string> transcoded{};  ///< role -> codec, "mjpeg" or "mpeg4"; both 4:2:0
    std::string attachment_name{};                    ///< if not empty, the scene's new name
    bool checksums = true;                            ///< whether headers and tags carry CRC-32 elements
    /// Packets to leave out.
    std::function<bool(const std::string& role, int number)> drop = [](const std::string&, int) {
        return false;
    };
};

void remux(const std::filesystem::path& from, const std::filesystem::path& to, const Remux& changes);

/// The bytes of every packet, track after track.
std::vector<std::string> packets(const std::filesystem::path& clip);

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
