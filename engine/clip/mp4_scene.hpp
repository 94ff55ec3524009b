#pragma once

#include <optional>

#include "engine/base/given_file.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/mpeg4/clip_nodes.hpp"
#include "engine/mpeg4/scene_stream.hpp"
#include "engine/picture/demuxer.hpp"

namespace touchable {

/// What an MP4 file's MPEG-4 scene says of a touchable clip, and which tracks that is.
struct Mp4Scene {
    mpeg4::SceneStream stream;
    mpeg4::ClipNodes nodes;
};

/// Nothing where a file has no such scene. Errors name the file.
Result<std::optional<Mp4Scene>> read_mp4_scene(const SourceFile& file);

/// The number of the track that a plane is; nothing where the scene has no such plane. Errors have no place.
Result<std::optional<std::uint32_t>> track_of_plane(const Mp4Scene& scene, PlaneRole role);
/// Likewise which of a file's streams of pictures it is.
Result<std::optional<int>> stream_of_plane(const Mp4Scene& scene, const Demuxer& file, PlaneRole role);

}  // namespace touchable
