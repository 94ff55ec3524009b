#pragma once

// Shared by readers and writers of our Matroska and MP4 files, beside tracks.hpp: values of tags, names of
// files, the frames' times as text, and tracks that are decoded while being written.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/clip/tracks.hpp"

namespace touchable {

namespace clip_tags {

/// Parses a version tag; nullopt unless it is a whole number from 1.
std::optional<std::int64_t> parse_version(std::string_view text);
/// Parses the tag of the bits of a sample stored in two bytes; nullopt unless 9 to 16.
std::optional<int> parse_bits(std::string_view text);
std::optional<FrameRate> parse_rate(std::string_view text);

/// Timestamps in milliseconds tell frames apart up to this many frames per second.
inline constexpr int fastest_rate = 1000;
bool is_too_fast(const FrameRate& rate);

}  // namespace clip_tags

// Metadata of our MP4 files beyond the MPEG-4 scene (docs/codecs.md): tags of the file, as in Matroska
// (clip_tags), and these.
inline constexpr const char* mp4_scene_tag = "T3D_SCENE";  ///< the scene file's text
inline constexpr const char* mp4_poses_tag = "T3D_POSES";  ///< timed_poses_text (engine/scene/scene.hpp)
inline constexpr const char* mp4_times_tag = "T3D_TIMES";  ///< frame_times_text, of a variable rate
/// From version 3 on, the scene has `hapticSurface` in Depth; from 4 on, its root is an OrderedGroup.
/// Fragments, which have no scene, are still of version 2.
inline constexpr int mp4_format_version = 4;

/// The error of a file without a frame, behind its name.
inline std::string why_without_frames(bool is_cut) {
    return is_cut ? "is truncated: it ends before its first whole frame" : "has no frames";
}

/// `told`: the tracks of each plane, instead of the file's own statement.
std::unique_ptr<ClipContainer> mp4_container(const SourceFile& file,
                                             const std::optional<PlaneTracks>& told = {});

/// Frame times of a variable rate, in the "timestamp format v2" of mkvtoolnix: a line that says so, and one
/// line per frame in order, milliseconds with six decimals (exact to the nanosecond up to 46 days).
std::string frame_times_text(const FrameRate& rate);
/// Parses that text; `name`: how messages call it. The first time counts as 0.
Result<FrameRate> parse_frame_times(std::string_view text, const std::string& name);

/// Whether a name ends in `ending`, in small or capital letters.
bool has_ending(const std::filesystem::path& name, std::string_view ending);

/// Whether a track is the one that ordinary players are to show.
bool is_shown_by_players(PlaneRole role, const FrameCheck& check);

/// Decodes a track's packets while it is written, as its readers will get it.
class ReadAlong {
public:
    static Result<std::unique_ptr<ReadAlong>> open(const TrackEncoder& encoder, PlaneRole role);
    /// Decodes the encoder's next packet.
    Result<void> add(const AVPacket& packet);
    /// The last packet's picture; empty before the first. Valid until the next `add`.
    PlaneView picture() const { return newest_.view; }

private:
    explicit ReadAlong(TrackDecoder decoder) : decoder_(std::move(decoder)) {}

    TrackDecoder decoder_;
    Plane newest_;
};

}  // namespace touchable
