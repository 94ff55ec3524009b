// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/live_touch.hpp"

#include <algorithm>
#include <atomic>
#include <deque>
#include <string>
#include <thread>

#include "bench/clocks.hpp"
#include "bench/gpu/frames_in_turn.hpp"
#include "engine/base/try.hpp"
#include "engine/run/touch_run.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {
namespace {

constexpr int live_slots = 4;
constexpr std::int64_t slot_pause_ns = 200'000;  // pause while the ticks hold all slots

/// Runs all ticks on a thread.
class PacedTicks {
public:
    PacedTicks(const LiveTouch& set_up, const TouchSolver& solver, SurfaceTimeline& timeline, bool touches)
        : set_up_(set_up), solver_(solver), timeline_(timeline), touches_(touches) {
        late_us_.reserve(static_cast<std::size_t>(set_up.seconds * 1000));
    }

    void begin(std::int64_t start_ns) {
        thread_ = std::thread([this, start_ns] { run(start_ns); });
    }
    bool done() const { return done_.load(std::memory_order_acquire); }
    /// Waits until all ticks are done.
    void end() { thread_.join(); }
    std::vector<double> late_us() { return std::move(late_us_); }
    bool fifo() const { return fifo_; }

private:
    void run(std::int64_t start_ns) {
        fifo_ = become_fifo();
        const auto fingers = static_cast<std::size_t>(set_up_.fingers);
        std::vector<FingerState> states(fingers);
        std::vector<Contact> contacts(fingers);
        const std::size_t paths = set_up_.goals.size() / fingers;
        for (std::size_t k = 0; k < late_us_.capacity(); ++k) {
            const std::int64_t due = start_ns + static_cast<std::int64_t>(k) * tick_length_ns;
            sleep_until(due);
            const std::int64_t now = monotonic_ns();
            late_us_.push_back(static_cast<double>(now - due) * 1e-3);
            FramePair pair;
            if (!touches_ || !timeline_.pair_at(now, pair)) continue;
            const auto goals = std::span(set_up_.goals).subspan(k % paths * fingers, fingers);
            solver_.tick(HeightField(set_up_.scene, pair), goals, states, contacts);
        }
        done_.store(true, std::memory_order_release);
    }

    const LiveTouch& set_up_;
    const TouchSolver& solver_;
    SurfaceTimeline& timeline_;
    const bool touches_;
    std::vector<double> late_us_;
    std::atomic<bool> done_ = false;
    bool fifo_ = false;
    std::thread thread_;
};

/// Builds and publishes frames until the ticks are done.
class PublishedFrames {
public:
    PublishedFrames(const LiveTouch& set_up, SurfaceBuilder& builder, SurfaceTimeline& timeline)
        : set_up_(set_up), builder_(builder), timeline_(timeline) {}

    Result<void> run(std::int64_t start_ns, const PacedTicks& ticks) {
        const bool paced = set_up_.rate > 0;
        const std::int64_t period_ns = paced ? static_cast<std::int64_t>(1e9 / set_up_.rate) : 0;
        const std::size_t most = paced ? 1 : static_cast<std::size_t>(builder_.frames_in_flight());
        for (std::int64_t n = 0; !ticks.done(); ++n) {
            if (paced) {
                // Skip frames that were due before the previous one was built.
                n = std::max(n, (monotonic_ns() - start_ns) / period_ns);
                sleep_until(start_ns + n * period_ns);
            }
            while (due_ns_.size() >= most) TRY(publish_next(ticks));
            due_ns_.push_back(paced ? start_ns + n * period_ns : monotonic_ns());
            TRY(builder_.begin(set_up_.ring.frame(n)));
            if (paced) TRY(publish_next(ticks));
        }
        while (!due_ns_.empty()) TRY(publish_next(ticks));
        return {};
    }
    std::int64_t published() const { return published_; }
    double mean_latency_ms() const {
        return published_ > 0 ? latency_ms_ / static_cast<double>(published_) : 0;
    }

private:
    Result<void> publish_next(const PacedTicks& ticks) {
        const std::int64_t due = due_ns_.front();
        due_ns_.pop_front();
        SurfaceFrame* slot = nullptr;
        while ((slot = timeline_.acquire()) == nullptr && !ticks.done())
            sleep_until(monotonic_ns() + slot_pause_ns);
        SurfaceFrame last;  // used after the last tick, when no slot gets free
        TRY(builder_.finish(slot ? *slot : last));
        if (!slot) return {};
        const std::int64_t now = monotonic_ns();
        TRY(timeline_.publish(published_, now));
        latency_ms_ += static_cast<double>(now - due) * 1e-6;
        ++published_;
        return {};
    }

    const LiveTouch& set_up_;
    SurfaceBuilder& builder_;
    SurfaceTimeline& timeline_;
    std::deque<std::int64_t> due_ns_;  // of the frames in flight
    std::int64_t published_ = 0;
    double latency_ms_ = 0;
};

}  // namespace

double LiveTimes::late_us_at(double share) const {
    if (late_us.empty()) return 0;
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(late_us.size()));
    return late_us[std::min(rank, late_us.size() - 1)];
}

Result<LiveTimes> touch_live(const LiveTouch& set_up, SurfaceBuilder* builder) {
    TouchSettings settings;
    settings.metres_per_scene_unit = set_up.scene.device_metres_per_unit.value();
    TRY_ASSIGN(const auto solver, TouchSolver::create(set_up.scene, settings));
    SurfaceTimeline timeline(live_slots);
    PacedTicks ticks(set_up, solver, timeline, builder != nullptr);
    const std::int64_t start = monotonic_ns() + 5 * tick_length_ns, cpu = process_cpu_ns();
    ticks.begin(start);
    Result<void> built;
    LiveTimes times;
    if (builder) {
        PublishedFrames frames(set_up, *builder, timeline);
        built = frames.run(start, ticks);
        times.frames_per_s = static_cast<double>(frames.published()) / set_up.seconds;
        times.latency_ms = frames.mean_latency_ms();
    }
    ticks.end();
    if (!built) return built.error();
    times.cpu_ms_per_s = static_cast<double>(process_cpu_ns() - cpu) * 1e-6 / set_up.seconds;
    times.late_us = ticks.late_us();
    times.fifo = ticks.fifo();
    std::ranges::sort(times.late_us);
    return times;
}

Result<void> measure_jitter(int width, int height, const TimedFilter& filter, double seconds,
                            const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    constexpr int fingers = 5;
    TRY_ASSIGN(const auto ring, ring_of_bumps(width, height));
    const Scene scene = with_filter(ring.scene(), filter);
    TRY(check_alike(scene, ring, 2, kernels));
    const auto goals = goals_over(ring, fingers, static_cast<int>(1000 * seconds));
    const LiveTouch set_up{scene, ring, goals, fingers, 0, seconds};
    const auto cpu = make_cpu_builder(scene);
    TRY_ASSIGN(const auto vulkan, make_vulkan_builder(scene, kernels, plan_for(kernels->device()->facts())));
    const std::pair<const char*, SurfaceBuilder*> ways[] = {
        {"alone", nullptr}, {"cpu", cpu.get()}, {"vulkan", vulkan.get()}};
    for (const auto& [name, builder] : ways) {
        TRY_ASSIGN(const auto times, touch_live(set_up, builder));
        if (builder && times.frames_per_s == 0)
            return Error{ErrorKind::check, std::string(name) + ": no frame was built beside the ticks"};
        const std::string what = name;
        figures.push_back({what + "_late_us_p50", times.late_us_at(0.5), "us"});
        figures.push_back({what + "_late_us_p99", times.late_us_at(0.99), "us"});
        figures.push_back({what + "_late_us_p999", times.late_us_at(0.999), "us"});
        if (builder) figures.push_back({what + "_frames_per_s", times.frames_per_s, ""});
        if (!builder) figures.push_back({"fifo", times.fifo ? 1.0 : 0.0, ""});
    }
    return {};
}

}  // namespace touchable
