#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/mpeg4/bifs.hpp"
#include "engine/mpeg4/boxes.hpp"

namespace touchable::mpeg4 {

// How an MP4 file carries a scene (ISO/IEC 14496-14): its initial object descriptor (box iods) names two
// tracks of MPEG-4 Systems, one of BIFS (handler sdsm) and one of object descriptors (odsm), which say which
// track each number in the scene means.

/// A scene, and the tracks of its pictures.
struct SceneStream {
    BifsConfig config;
    Bytes scene;                                     ///< one access unit
    std::map<std::uint16_t, std::uint32_t> objects;  ///< object descriptor -> track_ID
};

/// The bytes of a file from `at` on, `count` of them.
using ReadBytes = std::function<Result<Bytes>(std::uint64_t at, std::uint64_t count)>;

/// What a movie box says; nothing where it has no scene. Samples are read by `read`.
Result<std::optional<SceneStream>> read_scene_stream(BytesView moov, const ReadBytes& read);

/// Where the first sample of a track is, and how many the track has.
struct FirstSample {
    std::uint64_t at = 0, bytes = 0, count = 0;
};
/// By a movie box. An error where it has no such track, or that has no sample.
Result<FirstSample> first_sample_of(BytesView moov, std::uint32_t track);

/// What stands in place of a movie box at `at`, so that its file has a scene: a box with the samples of both
/// tracks (mdat), and the movie box with iods and those tracks. Other samples stay where they are, so it must
/// be the file's last box. Beside `shown`, tracks of pictures are marked as auxiliary to it (handler auxv,
/// reference vdep): ordinary players leave them alone. All that are objects of the scene are enabled.
Result<Bytes> with_scene_stream(BytesView moov, const SceneStream& stream, std::uint32_t shown,
                                std::uint64_t at);
/// A movie box whose tracks of pictures are marked so, and that has no scene.
Result<Bytes> with_auxiliary_tracks(BytesView moov, std::uint32_t shown);

}  // namespace touchable::mpeg4
