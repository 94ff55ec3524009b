#pragma once

#include <string>

#include "engine/base/result.hpp"
#include "engine/clip/frame_check.hpp"
#include "engine/clip/track_encoder.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

// What a clip of ours says in Matroska, in a file and in a stream. Before the muxer's header is written;
// errors where memory runs out.

/// The scene as the clip says it: its frames are here now.
SceneDescription said_of_clip(const SceneDescription& described);

/// Of the whole: its rate, and that it is a clip of ours, of this version.
void add_clip_tags(AVFormatContext& muxer, const FrameRate& rate, int version);

/// A track of pictures, its times in milliseconds; `check` knows the planes.
Result<void> add_plane_stream(AVFormatContext& muxer, const TrackEncoder& encoder, PlaneRole role,
                              TrackCoding coding, const FrameCheck& check, const Scene& scene);

/// Ordinary players show the track that is there to be seen.
bool is_shown_by_players(PlaneRole role, const FrameCheck& check);

Result<void> attach_text(AVFormatContext& muxer, const char* name, const char* type, const std::string& text);

}  // namespace touchable
