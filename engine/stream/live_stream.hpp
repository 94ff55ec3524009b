#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/stream/stream_bytes.hpp"
#include "engine/stream/stream_url.hpp"
#include "engine/stream/stream_wait.hpp"

namespace touchable {

/// A stream as a live source.
struct StreamChoice {
    StreamUrl url;
    std::chrono::milliseconds latency{200};  ///< the longest that framesets wait for others' sake
    StreamPatience patience{};
    std::shared_ptr<StreamBytes> connection{};  ///< that is there already, for the first who opens it
};

/// Its framesets as they come, each shown when JitterBuffer says. A thread of its own receives them. A sender
/// who goes, or is silent, is connected to again, at first after `patience.back_off`, then ever less often;
/// meanwhile the last frameset stands still. One that then sends another scene, or other planes, ends the
/// stream. `described`: in place of its own scene.
Result<std::unique_ptr<ClipReader>> open_live_stream(const StreamChoice& choice,
                                                     const std::optional<SceneDescription>& described = {});

}  // namespace touchable
