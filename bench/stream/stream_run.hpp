#pragma once

#include <string>

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"
#include "tests/stream/relay.hpp"

namespace touchable {

/// A clip that `touchable serve` sends over a network of this machine, and five fingers that touch what
/// comes, in this process.
struct StreamCase {
    std::string transport;  ///< "tcp", "http", "srt", "ts" (MPEG-TS by SRT)
    LiveClip clip;
    test::NetworkFaults faults{};
    bool is_far = false;  ///< forces are compared with those of no delay (DelayedTouch)
};

/// Touches it live for as long as the clip lasts; what became of its framesets, how long from sending to
/// force, how forces stepped, and the CPU of both.
Result<void> measure_stream(const StreamCase& stream, LiveClips& clips, Figures& figures);

/// The same of the clip as a camera (`replay:`), which no network comes between: what the others are compared
/// with.
Result<void> measure_without_network(const LiveClip& clip, LiveClips& clips, Figures& figures);

/// What it costs to send a clip to so many listeners at once, by TCP, none of which does anything with it.
Result<void> measure_listeners(int listeners, const LiveClip& clip, LiveClips& clips, Figures& figures);

}  // namespace touchable
