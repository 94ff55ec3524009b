#pragma once

// What the readers and writers of our Matroska and MP4 files share, beside tracks.hpp: values of tags, names
// of files, the frames' times as text, and tracks that are read as they are written.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/clip/tracks.hpp"

namespace touchable {

namespace clip_tags {

/// A version as its tag has it; nothing unless it is a whole number from 1.
std::optional<std::int64_t> parse_version(std::string_view text);
/// Bits of a sample that is stored in two bytes, as their tag has them; nothing unless 9 to 16.
std::optional<int> parse_bits(std::string_view text);
std::optional<FrameRate> parse_rate(std::string_view text);

/// Timestamps in milliseconds tell frames apart up to this many frames per second.
inline constexpr int fastest_rate = 1000;
bool is_too_fast(const FrameRate& rate);

}  // namespace clip_tags

// How an MP4 of ours says what it is beyond its MPEG-4 scene (docs/codecs.md): tags of the file, as in
// Matroska (clip_tags), and these.
inline constexpr const char* mp4_scene_tag = "T3D_SCENE";  ///< the scene file's text
inline constexpr const char* mp4_poses_tag = "T3D_POSES";  ///< timed_poses_text (engine/scene/scene.hpp)
inline constexpr const char* mp4_times_tag = "T3D_TIMES";  ///< frame_times_text, of a variable rate
/// From version 3 on, the scene has `hapticSurface` in Depth. Fragments, which have no scene, are still of
/// version 2.
inline constexpr int mp4_format_version = 3;

/// `told`: which tracks are which plane, whatever the file says of that itself.
std::unique_ptr<ClipContainer> mp4_container(const SourceFile& file,
                                             const std::optional<PlaneTracks>& told = {});

/// The times of frames of variable rate, in the "timestamp format v2" of mkvtoolnix: a line that says so, and
/// one line per frame in its order, milliseconds. With six decimals, which is to the nanosecond up to 46
/// days.
std::string frame_times_text(const FrameRate& rate);
/// The same back; `name` is how messages call the text. The first time counts as 0.
Result<FrameRate> parse_frame_times(std::string_view text, const std::string& name);

/// Whether a name ends so, in small or capital letters.
bool has_ending(const std::filesystem::path& name, std::string_view ending);

/// Whether a track is the one that ordinary players are to show.
bool is_shown_by_players(PlaneRole role, const FrameCheck& check);

/// What a track's readers will be given, while it is written: its packets, decoded.
class ReadAlong {
public:
    static Result<std::unique_ptr<ReadAlong>> open(const TrackEncoder& encoder, PlaneRole role);
    /// The next packet that the encoder gave.
    Result<void> add(const AVPacket& packet);
    /// The picture in it; empty before the first. Until the next one.
    PlaneView picture() const { return newest_.view; }

private:
    explicit ReadAlong(TrackDecoder decoder) : decoder_(std::move(decoder)) {}

    TrackDecoder decoder_;
    Plane newest_;
};

}  // namespace touchable
