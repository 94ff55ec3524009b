#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/stream/stream_receiver.hpp"

namespace touchable {

/// A stream as a clip: framesets as they come, numbered from 0, at the times that its rate gives them, until
/// its sender ends it. Where one was lost the one before is given in its place. It goes on and not back: the
/// first ones alone are kept for a while, so that whoever looks at them can begin anew. Errors name the
/// stream and the frame.
Result<std::unique_ptr<ClipReader>> open_stream_clip(const StreamSource& source,
                                                     Colour colour = Colour::wanted);

}  // namespace touchable
