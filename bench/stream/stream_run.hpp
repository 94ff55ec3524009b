// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"
#include "tests/stream/relay.hpp"

namespace touchable {

/// A clip sent by `touchable serve` over this machine's network, and five fingers in this process that touch
/// it.
struct StreamCase {
    std::string transport;  ///< "tcp", "http", "srt", "ts" (MPEG-TS over SRT)
    LiveClip clip;
    test::NetworkFaults faults{};
};

/// Touches it live for the clip's length; figures of framesets received and lost, delay from sending to
/// force, steps of forces, and CPU time of both processes.
Result<void> measure_stream(const StreamCase& stream, LiveClips& clips, Figures& figures);

/// The same with the clip as a camera (`replay:`), without a network, as reference.
Result<void> measure_without_network(const LiveClip& clip, LiveClips& clips, Figures& figures);

/// Measures the cost of sending a clip by TCP to `listeners` listeners at once, which discard it.
Result<void> measure_listeners(int listeners, const LiveClip& clip, LiveClips& clips, Figures& figures);

}  // namespace touchable
