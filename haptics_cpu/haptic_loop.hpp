#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/boot_time.hpp"
#include "engine/base/result.hpp"
#include "haptics_cpu/haptic_port.hpp"
#include "haptics_cpu/realtime.hpp"
#include "haptics_cpu/tick_log.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {

/// How a loop went; complete once it has ended.
struct LoopFacts {
    RealtimeGrant grant;
    std::int64_t ticks = 0;
    std::int64_t late = 0;       ///< wake-ups a whole tick or more too late
    std::int64_t skipped = 0;    ///< ticks whose time had passed by then; never made up for
    std::int64_t gaps = 0;       ///< of more than `longest_gap_ns` without a tick
    std::int64_t lost = 0;       ///< ticks for which the log had no room
    double longest_port_ms = 0;  ///< that the port took in one tick, its reading and its writing together
    bool port_failed = false;    ///< it said so, or threw
    bool broke_off = false;      ///< something else threw in a tick: a fault of the program
};

/// The haptic thread: a tick every millisecond of the wall clock, each over the frames around its own time.
/// It never waits for anybody, never allocates; a tick that comes too late is counted and the missed ones are
/// skipped (docs/architecture.md, Threads).
class HapticLoop {
public:
    /// Which moment of the clip a tick is of; asked tick by tick by the haptic thread, so it must not wait.
    /// Nothing: the tick's own time, of epoch 0.
    using MomentOfTick = std::function<MediaMoment(std::int64_t)>;
    /// A hand that got no tick for longer was left alone: the program was stopped, the machine was suspended
    /// or had other work. By then it has no force any more; the next tick begins with TouchStep::come_back.
    static constexpr std::int64_t longest_gap_ns = 50'000'000;
    /// All of them outlive the loop; the loop is `timeline`'s one reader and `log`'s one writer.
    HapticLoop(const Scene& scene, SurfaceTimeline& timeline, TouchStep& step, HapticPort& port, TickLog& log,
               MomentOfTick moment_of_tick = {});
    ~HapticLoop();  ///< stops it
    HapticLoop(const HapticLoop&) = delete;
    HapticLoop& operator=(const HapticLoop&) = delete;

    /// The loop ends by itself before that tick, even where no other thread can stop it. Before `start`.
    void end_before(std::int64_t tick) { end_ = tick; }
    /// The clock by which a gap is seen, in place of boot_ns: ns, never backward. Before `start`.
    void see_gaps_by(std::function<std::int64_t()> clock) { clock_ = std::move(clock); }
    /// Begins tick 0 now. At least one frame has been published. A loop runs once: what its fingers carry
    /// over knows nothing of a pause, and the hand would get a force without a ramp. An error then, and where
    /// the machine has no thread left.
    Result<void> start();
    /// Ends after the tick in progress, with zero force written; does nothing before it started or once it
    /// has ended.
    void stop();
    /// Likewise, and does not wait for that. Any thread.
    void ask_to_stop() { stopping_.store(true, std::memory_order_relaxed); }
    bool running() const { return !ended_.load(std::memory_order_acquire); }
    /// Time of the newest tick begun: tick k is at k ms.
    std::int64_t time_ns() const { return time_ns_.load(std::memory_order_relaxed); }
    /// When tick 0 was due; nothing until its thread has come so far.
    std::optional<std::chrono::steady_clock::time_point> zero() const;
    /// After `stop`, or once it is not running.
    const LoopFacts& facts() const { return facts_; }

private:
    static constexpr auto not_begun = std::chrono::steady_clock::time_point::min();

    void run();
    void tick_until_stopped();
    bool tick(std::int64_t tick, double late_us);
    void look_for_gap();

    const Scene& scene_;
    SurfaceTimeline& timeline_;
    TouchStep& step_;
    HapticPort& port_;
    TickLog& log_;
    const MomentOfTick moment_of_tick_;
    std::function<std::int64_t()> clock_ = boot_ns;
    std::int64_t ticked_ns_ = 0;  // by that clock, when the newest tick began
    std::vector<glm::dvec3> newtons_;
    std::vector<double> shares_;
    LoopFacts facts_;
    std::optional<std::int64_t> end_;
    bool started_ = false;
    std::atomic<bool> stopping_{false}, ended_{true};
    std::atomic<std::int64_t> time_ns_{0};
    std::atomic<std::chrono::steady_clock::time_point> zero_{not_begun};
    std::thread thread_;
};

}  // namespace touchable
