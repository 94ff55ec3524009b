#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/scene/frame_rate.hpp"

namespace touchable {

/// The times of frames of variable rate, in the "timestamp format v2" of mkvtoolnix: a line that says so, and
/// one line per frame in its order, milliseconds. With six decimals, which is to the nanosecond up to 46
/// days.
std::string frame_times_text(const FrameRate& rate);

/// The same back; `name` is how messages call the text. The first time counts as 0.
Result<FrameRate> parse_frame_times(std::string_view text, const std::string& name);

}  // namespace touchable
