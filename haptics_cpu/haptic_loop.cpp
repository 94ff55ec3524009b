#include "haptics_cpu/haptic_loop.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/start_thread.hpp"

namespace touchable {

using std::chrono::steady_clock;

namespace {

constexpr std::chrono::milliseconds tick_time(1);

/// What a port answers. One that throws has failed, like one that says so.
template <class Call>
bool answer_of(Call&& call) noexcept {
    try {
        return call();
    } catch (...) {
        return false;
    }
}

}  // namespace

HapticLoop::HapticLoop(const Scene& scene, SurfaceTimeline& timeline, TouchStep& step, HapticPort& port,
                       TickLog& log, MomentOfTick moment_of_tick)
    : scene_(scene),
      timeline_(timeline),
      step_(step),
      port_(port),
      log_(log),
      moment_of_tick_(std::move(moment_of_tick)),
      newtons_(static_cast<std::size_t>(step.fingers())),
      shares_(static_cast<std::size_t>(step.fingers())) {}

HapticLoop::~HapticLoop() {
    stop();
}

Result<void> HapticLoop::start() {
    if (started_) return Error{ErrorKind::internal, "a haptic loop runs once; make another"};
    ended_.store(false, std::memory_order_release);
    auto begun = start_thread(thread_, "haptic-loop", "of the hand", [this] { run(); });
    started_ = begun.ok();
    if (!started_) ended_.store(true, std::memory_order_release);
    return begun;
}

void HapticLoop::stop() {
    if (!thread_.joinable()) return;
    ask_to_stop();
    thread_.join();
}

std::optional<steady_clock::time_point> HapticLoop::zero() const {
    const auto zero = zero_.load(std::memory_order_relaxed);
    return zero == not_begun ? std::nullopt : std::optional(zero);
}

/// Nothing thrown leaves the thread, and whatever ends it, the hand is left with zero force.
void HapticLoop::run() {
    facts_.grant = become_realtime();
    try {
        tick_until_stopped();
    } catch (...) {
        facts_.broke_off = true;
    }
    std::fill(newtons_.begin(), newtons_.end(), glm::dvec3(0.0));
    answer_of([this] { return port_.write_forces(newtons_); });
    ended_.store(true, std::memory_order_release);
}

void HapticLoop::tick_until_stopped() {
    const auto start = steady_clock::now();
    zero_.store(start, std::memory_order_relaxed);
    ticked_ns_ = clock_();
    for (std::int64_t tick = 0; !stopping_.load(std::memory_order_relaxed); ++tick) {
        sleep_until(start + tick * tick_time);
        auto late = steady_clock::now() - (start + tick * tick_time);
        if (late >= tick_time) {
            ++facts_.late;
            const std::int64_t missed = late / tick_time;
            facts_.skipped += missed;
            tick += missed;
            late -= missed * tick_time;
        }
        if (end_ && tick >= *end_) return;
        ++facts_.ticks;
        if (!this->tick(tick, std::chrono::duration<double, std::micro>(late).count())) {
            facts_.port_failed = true;
            return;
        }
    }
}

/// By a clock that a suspended machine does not stop. (Ticks stand still then, as the clip does.)
void HapticLoop::look_for_gap() {
    const std::int64_t now = clock_(), alone_ns = now - std::exchange(ticked_ns_, now);
    if (alone_ns <= longest_gap_ns) return;
    ++facts_.gaps;
    step_.come_back();
    port_.come_back(alone_ns / 1'000'000);
}

bool HapticLoop::tick(std::int64_t tick, double late_us) {
    const std::int64_t time_ns = std::chrono::nanoseconds(tick * tick_time).count();
    time_ns_.store(time_ns, std::memory_order_relaxed);
    FramePair pair;
    timeline_.pair_at(moment_of_tick_ ? moment_of_tick_(tick) : MediaMoment{0, time_ns, 0}, pair);
    timeline_.show(tick);
    const HeightField field(scene_, pair);
    look_for_gap();
    const auto asked = steady_clock::now();
    if (!answer_of([&] { return port_.read_goals(tick, field, step_.goals()); })) return false;
    const auto read = steady_clock::now();
    TouchTick done = step_.run(tick, time_ns, scene_, pair);
    done.late_us = late_us;
    for (std::size_t k = 0; k < newtons_.size(); ++k) newtons_[k] = done.forces[k].force;
    const auto computed = steady_clock::now();
    const bool written = answer_of([this] { return port_.write_forces(newtons_); });
    const std::chrono::duration<double, std::milli> port = read - asked + (steady_clock::now() - computed);
    facts_.longest_port_ms = std::max(facts_.longest_port_ms, port.count());
    for (std::size_t k = 0; k < shares_.size(); ++k) shares_[k] = written ? port_.share(k) : 0;
    done.shares = shares_;
    if (!log_.push(done)) ++facts_.lost;
    return written;
}

}  // namespace touchable
