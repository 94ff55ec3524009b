#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engine/scene/scene.hpp"

namespace touchable::clip_tags {

// How a clip says what it is, in Matroska tags: T3D_VERSION and T3D_RATE of the file; of each track T3D_ROLE,
// T3D_LOSSLESS where it keeps every value, and T3D_BITS where samples of so many bits are stored as bytes (by
// FFmpeg's codecs the high ones in the upper half of the picture); and the name under which the scene is
// attached.
inline constexpr const char* version_tag = "T3D_VERSION";
inline constexpr const char* rate_tag = "T3D_RATE";
/// Of the file: it is a stream, which ends where it was cut off.
inline constexpr const char* stream_tag = "T3D_STREAM";
inline constexpr const char* role_tag = "T3D_ROLE";
inline constexpr const char* lossless_tag = "T3D_LOSSLESS";
inline constexpr const char* bits_tag = "T3D_BITS";
inline constexpr const char* scene_file = "scene.json";
/// The attachment of a clip of variable rate (frame_times_text.hpp).
inline constexpr const char* times_file = "timestamps.txt";
/// Likewise where the camera stood (camera_path.hpp).
inline constexpr const char* poses_file = "poses.txt";

/// From version 2 on, all tracks store a picture that decoding can begin with every so many frames.
inline constexpr std::int64_t access_interval = 15;

/// A version as its tag has it; nothing unless it is a whole number from 1.
std::optional<std::int64_t> parse_version(std::string_view text);

/// Bits of a sample that is stored in two bytes, as their tag has them; nothing unless 9 to 16.
std::optional<int> parse_bits(std::string_view text);

/// "30000/1001": exact, because Matroska rounds timestamps to milliseconds.
std::string rate_text(const FrameRate& rate);
std::optional<FrameRate> parse_rate(std::string_view text);
bool same_rate(const FrameRate& a, const FrameRate& b);
/// What a person should know where a scene file has frames played at another rate than they were recorded at.
std::optional<std::string> rate_note(const FrameRate& played, const FrameRate& recorded);

/// Timestamps in milliseconds tell frames apart up to this many frames per second.
inline constexpr int fastest_rate = 1000;
bool is_too_fast(const FrameRate& rate);

}  // namespace touchable::clip_tags
