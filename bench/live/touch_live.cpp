// SPDX-License-Identifier: Apache-2.0
#include "bench/live/touch_live.hpp"

#include <algorithm>
#include <thread>

#include "bench/clocks.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {
namespace {

/// Counts ticks that began noticeably late.
class LateTicks final : public TouchSink {
public:
    static constexpr double late_us = 200;
    Result<void> consume(const TouchTick& tick) override {
        late_ += tick.late_us > late_us;
        return {};
    }
    std::int64_t late() const { return late_; }

private:
    std::int64_t late_ = 0;
};

double percent(double part, double whole) {
    return whole > 0 ? 100 * part / whole : 0;
}

}  // namespace

Result<void> measure_live(const LiveClip& clip, LiveClips& clips, Figures& figures) {
    const auto file = clips.file(clip);
    if (!file) return file.error();
    SessionOptions options;
    options.clip.file = *file;
    options.fingers = 5;
    options.live = true;
    const auto setup = setup_from_options(options);
    if (!setup) return setup.error();
    TouchSetup& s = **setup;

    TouchFigures touched;
    LateTicks ticks;
    TouchSink* const sinks[]{&touched, &ticks};
    const auto hand = make_port(*s.hand);
    TouchSessionSettings settings = s.options;
    settings.ticks = s.ticks();
    LiveSession session(*s.feed, *hand, *s.solver, settings);
    const std::int64_t wall = monotonic_ns(), cpu = process_cpu_ns();
    if (auto ran = session.run(sinks); !ran) return ran;
    const auto wall_ns = static_cast<double>(monotonic_ns() - wall);
    const auto cpu_ns = static_cast<double>(process_cpu_ns() - cpu);
    const LiveFacts& facts = session.facts();
    if (facts.failure) return *facts.failure;
    if (facts.interrupted) return Error{ErrorKind::interrupted, "interrupted"};

    const auto frames = static_cast<double>(s.feed->frames());
    const auto due = static_cast<double>(facts.loop.ticks + facts.loop.skipped);
    // Skipped ticks count as late.
    const auto late_ticks = static_cast<double>(ticks.late() + facts.loop.skipped);
    const Spread read = s.feed->read_ms().spread(), build = s.feed->build_ms().spread();
    figures.push_back({"frames", frames, ""});
    figures.push_back({"late_frames", static_cast<double>(facts.late_frames), ""});
    figures.push_back({"late_frames_pct", percent(static_cast<double>(facts.late_frames), frames), "%"});
    figures.push_back({"ticks", due, ""});
    figures.push_back({"late_ticks_pct", percent(late_ticks, due), "%"});
    figures.push_back({"tick_late_us_p99", touched.late_us().p99, "us"});
    figures.push_back({"fifo", facts.loop.grant.fifo ? 1.0 : 0.0, ""});
    figures.push_back({"read_ms_p50", read.p50, "ms"});
    figures.push_back({"read_ms_p99", read.p99, "ms"});
    figures.push_back({"build_ms_p99", build.p99, "ms"});
    const double cores = std::max(std::thread::hardware_concurrency(), 1U);
    figures.push_back({"cores_used_pct", percent(cpu_ns, cores * wall_ns), "%"});
    return {};
}

}  // namespace touchable
