#pragma once

#include <memory>

#include "engine/stream/stream_bytes.hpp"

namespace touchable {

/// StreamBytes::connect by SRT: calls, again and again until somebody answers, or (mode=listener) waits for a
/// caller.
Result<std::shared_ptr<StreamBytes>> connect_by_srt(const StreamUrl& url, std::shared_ptr<StreamWait> wait);

}  // namespace touchable
