#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "engine/scene/scene_description.hpp"
#include "engine/stream/stream_muxer.hpp"

namespace touchable {

/// Framesets as MPEG-TS, which stock tools read: each plane a track of H.264 that says what it is
/// (LabelledEncoder), colour first. It has no header: everything that a listener needs is in each key block.
/// A block is whole packets of 188 bytes. Refused is a scene that no clip can have.
Result<std::unique_ptr<StreamMuxer>> make_mpegts_muxer(const SceneDescription& described);

}  // namespace touchable
