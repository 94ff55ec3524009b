#include "player/session/live_session.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "player/session/feed_threads.hpp"
#include "player/session/interrupt.hpp"
#include "player/session/live_line.hpp"

namespace touchable {

namespace {

// Ticks that may wait for the sinks: four seconds, far longer than a disk sleeps.
constexpr int log_ticks = 4096;
constexpr std::chrono::milliseconds sink_pause(2);

/// Whether a frame that is there now was needed before: a held one from its own time on, one that the surface
/// goes to (`linear`) as soon as it leaves the frame before.
bool comes_late(const RawFrame& raw, const Scene& scene, std::int64_t now_ns) {
    if (scene.interpolation == FrameInterpolation::hold) return now_ns >= raw.time_ns;
    return now_ns > scene.rate.time_ns(raw.number - 1);
}

}  // namespace

LiveSession::LiveSession(const Scene& scene, SurfaceFeed& feed, Hand& hand, HapticPort& port,
                         const TouchSolver& solver, const TouchSessionSettings& settings)
    : scene_(scene), feed_(feed), hand_(hand), port_(port), solver_(solver), settings_(settings) {}

Result<void> LiveSession::run(std::span<TouchSink* const> sinks) {
    if (interrupted()) return interrupted_error();
    TouchStep step(solver_, settings_.guard, settings_.fingers);
    TickLog log(log_ticks, settings_.fingers);
    HapticLoop loop(scene_, feed_.timeline(), step, port_, log);
    FeedThreads threads(feed_, [&](const RawFrame& raw) { return comes_late(raw, scene_, loop.time_ns()); });

    Result<void> taken;
    LiveLine line;
    auto drain = [&] {
        const auto give = [&](const TouchTick& tick) {
            for (TouchSink* sink : sinks)
                if (taken.ok()) taken = sink->take(tick);
            if (taken.ok()) taken = line.take(tick);
        };
        while (log.pop(give)) {
        }
    };
    const auto is_over = [&] {
        if (const auto ticks = settings_.ticks ? settings_.ticks : hand_.ticks())
            return loop.time_ns() >= (*ticks - 1) * tick_ns;
        const auto end = threads.end_ns();
        return end && loop.time_ns() + tick_ns >= std::max(*end, shortest_run_ns);
    };
    if (auto begun = threads.start(); !begun.ok()) return begun;
    if (auto begun = loop.start(); !begun.ok()) return begun;
    while (loop.running() && taken.ok() && !threads.error() && !is_over()) {
        facts_.interrupted = interrupted();
        if (facts_.interrupted) break;
        drain();
        line.show(threads.late_frames());
        std::this_thread::sleep_for(sink_pause);
    }
    loop.stop();
    threads.stop();
    drain();
    facts_.loop = loop.facts();
    facts_.late_frames = threads.late_frames();
    facts_.failure = threads.error();
    if (!facts_.failure && facts_.loop.port_failed)
        facts_.failure =
            Error{ErrorKind::device, "the device stopped answering in the middle of the session"};
    if (!taken.ok()) return taken;
    if (facts_.loop.broke_off)
        return Error{ErrorKind::internal, "the haptic thread met a fault of this program and ended"};
    if (facts_.loop.ticks == 0 && facts_.failure) return *facts_.failure;
    if (facts_.loop.ticks == 0 && facts_.interrupted) return interrupted_error();
    if (facts_.loop.lost > 0)
        return Error{ErrorKind::internal, std::to_string(facts_.loop.lost) +
                                              " ticks were lost on their way to the files; the disk "
                                              "is too slow for what was asked to be written"};
    return {};
}

}  // namespace touchable
