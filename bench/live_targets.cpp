// SPDX-License-Identifier: Apache-2.0
#include "bench/targets.hpp"

namespace touchable {
namespace {

std::vector<Target> make_live_targets() {
    using Sense = Limit::Sense;
    using Cases = std::vector<std::string>;
    const std::string feed = "feed-globe-1920x1080-16";
    const Cases demo{"live-globe-720x480-16"}, touch{feed}, colour{feed + "-colour"}, small{feed + "-small"},
        depth{feed + "-depth", "feed-moving-1920x1080-16-depth"}, memory{"memory-1920x1080"};
    std::vector<Target> targets;
    const auto add = [&](const char* what, const Cases& cases, const char* metric, Sense sense, double value,
                         const char* unit) {
        targets.push_back({what, cases, metric, {value, sense, unit}});
    };
    add("globe 720x480, live, 5 fingers: late frames", demo, "late_frames_pct", Sense::at_most, 0, "%");
    add("error bars, of a core at 30 framesets/s", {feed, "feed-globe-720x480-16"}, "error_bars_pct",
        Sense::at_most, 5, "%");
    // CPU times over those of FFmpeg's decoders for the same packets, on one thread.
    add("reading and building 1920x1080 over FFmpeg", touch, "feed_cpu_vs_ffmpeg", Sense::at_most, 3.5, "");
    add("  with colour", colour, "feed_cpu_vs_ffmpeg", Sense::at_most, 3, "");
    add("  of the cores left at 30 framesets/s", colour, "cores_left_pct", Sense::at_least, 30, "%");
    add("reading depth, haptic and height over FFmpeg", touch, "read_cpu_vs_ffmpeg", Sense::at_most, 2, "");
    add("  depth alone, over its decoder", depth, "read_cpu_vs_ffmpeg", Sense::at_most, 1.6, "");
    add("bytes over FFV1's, archive fast", touch, "vs_ffv1", Sense::at_most, 1.4, "");
    add("  depth that moves everywhere", {depth.back()}, "vs_ffv1", Sense::at_most, 1.4, "");
    add("  archive small", small, "vs_ffv1", Sense::at_most, 0.7, "");
    add("ticks late by over 0.2 ms while it runs", {demo.front(), "live-globe-1920x1080-16"},
        "late_ticks_pct", Sense::at_most, 0.1, "%");
    add("seek in a clip of 10 minutes, p99", {"seek-720x480-600s"}, "seek_ms_p99", Sense::at_most, 100, "ms");
    add("  of 20 seconds", {"seek-720x480-20s"}, "seek_ms_p99", Sense::at_most, 100, "ms");
    add("peak memory, 1920x1080 live", memory, "live_mb", Sense::at_most, 300, "MB");
    add("  make", memory, "make_mb", Sense::at_most, 500, "MB");
    return targets;
}

}  // namespace

const std::vector<Target>& live_targets() {
    static const std::vector<Target> targets = make_live_targets();
    return targets;
}

}  // namespace touchable
