#pragma once

#include <memory>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/picture/stored_sound.hpp"
#include "engine/scene/scene_description.hpp"
#include "engine/stream/stream_muxer.hpp"

namespace touchable {

/// A stream in our clips' own form, Matroska: tracks with their roles, the scene attached, and for each
/// frameset one picture of every plane, labelled (BlockAddition), in clusters of its own. Touch is lossless,
/// colour as good as the eye can tell. `sound`, where there is any, goes along, and begins anew with each
/// frame of another epoch (RawFrame::epoch): a loop's next round. Header and blocks one after the other, from
/// any key block on, are a clip.
///
/// Refused: a scene that no clip can have, sound that cannot be stored; by the first `add` (ErrorKind::usage)
/// pictures of a size that cannot be encoded.
Result<std::unique_ptr<StreamMuxer>> open_matroska_stream(const SceneDescription& described,
                                                          const std::optional<SoundPart>& sound = {});

}  // namespace touchable
