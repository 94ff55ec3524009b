#pragma once

#include <bit>
#include <filesystem>
#include <memory>
#include <optional>

#include "engine/clip/matroska_writer.hpp"

namespace touchable {

// How an MP4 of ours says what it is beyond its MPEG-4 scene (docs/mpeg4.md): tags of the file, as in
// Matroska (clip_tags.hpp), and these.
inline constexpr const char* mp4_scene_tag = "T3D_SCENE";  ///< the scene file's text
inline constexpr const char* mp4_poses_tag = "T3D_POSES";  ///< timed_poses_text (camera_path.hpp)
inline constexpr const char* mp4_times_tag = "T3D_TIMES";  ///< frame_times_text.hpp, of a variable rate
/// From version 3 on, the scene has `hapticSurface` in Depth. Fragments, which have no scene, are still of
/// version 2.
inline constexpr int mp4_format_version = 3;
/// Bits of the largest height code; the low ones beyond 8 are in a track of their own.
constexpr int height_bits(const HeightCoding& height) {
    return std::bit_width(height.code_max);
}
/// The name of a track (its handler's) that has the low bits of another one: "depth_low". The high eight are
/// in that one.
inline constexpr const char* low_track_suffix = "_low";

/// A touchable clip as the paper sends it: MP4 with a track of H.264 for each plane, and an MPEG-4 scene that
/// says what they are. Colour is the track that ordinary players show; the others are marked as auxiliary to
/// it. Depth and height of more than 8 bits have their low bits in tracks of their own, which the scene does
/// not name. `storage`: its archive says how hard the encoder tries; in fragments the file has no scene but
/// tags and names of tracks, and is readable up to the last half second that was written. Otherwise as
/// create_clip.
Result<std::unique_ptr<ClipWriter>> create_mp4_clip(const std::filesystem::path& path,
                                                    const SceneDescription& described,
                                                    const ClipStorage& storage = {},
                                                    Existing existing = Existing::replace,
                                                    const std::optional<SoundPart>& sound = {});

/// Whether a clip of this name is to be MP4: .mp4, in any case of letters.
bool is_mp4_name(const std::filesystem::path& path);
/// create_mp4_clip or create_clip, by its name.
Result<std::unique_ptr<ClipWriter>> create_named_clip(const std::filesystem::path& path,
                                                      const SceneDescription& described,
                                                      const ClipStorage& storage = {},
                                                      Existing existing = Existing::replace,
                                                      const std::optional<SoundPart>& sound = {});

}  // namespace touchable
