#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "engine/authoring/segment_store.hpp"
#include "engine/base/result.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// The segments of all frames of a clip, by a reader of its own, so that a run over it is not led to and
/// fro. `progress` as read_segments has it. Refused (ErrorKind::usage) of a camera. Takes long; once it was
/// `given_up`, an error of kind interrupted.
Result<SegmentStore> read_chosen_segments(const ClipChoice& choice,
                                          const std::function<void(std::int64_t frame)>& progress,
                                          const std::stop_token& given_up);

/// What a person said of the clip on which its segments depend, so that they are the same where it is; empty:
/// nothing.
std::string segments_depend_on(const ClipChoice& choice);

}  // namespace touchable
