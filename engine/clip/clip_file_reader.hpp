#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "engine/base/given_file.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/plane_role.hpp"

namespace touchable {

/// A touchable clip in Matroska; `described` replaces the scene attached to it.
Result<std::unique_ptr<ClipReader>> open_matroska_clip(const SourceFile& file,
                                                       const std::optional<SceneDescription>& described,
                                                       Colour colour = Colour::wanted);

/// The same in MP4, or any MP4 file whose MPEG-4 scene is a touchable clip (docs/mpeg4.md).
Result<std::unique_ptr<ClipReader>> open_mp4_clip(const SourceFile& file,
                                                  const std::optional<SceneDescription>& described,
                                                  Colour colour = Colour::wanted);
/// Whether a file is one of these: it has tags of ours, an MPEG-4 scene of a clip, or tracks that are named
/// as planes of touch. One whose scene is damaged may be, or is no clip where FFmpeg cannot read the file,
/// unless somebody else describes it: its reader says what is wrong with the scene.
bool is_mp4_clip(const SourceFile& file, bool is_described);

/// A plane in an MP4 file: the numbers of its track, and of that with the low bits of samples of more than 8.
struct NumberedTrack {
    std::uint32_t track = 0;
    std::optional<std::uint32_t> low{};
};
using PlaneTracks = std::array<std::optional<NumberedTrack>, all_roles.size()>;  ///< by PlaneRole

/// Tracks of an MP4 file of which another file says what they are and mean. It may be anybody's; one with
/// tags of ours says the frames' times.
Result<std::unique_ptr<ClipReader>> open_mp4_tracks(const SourceFile& file, const PlaneTracks& tracks,
                                                    const SceneDescription& described,
                                                    Colour colour = Colour::wanted);

}  // namespace touchable
