// SPDX-License-Identifier: Apache-2.0
#pragma once

// The loop of a thousand ticks a second, in real time.
//
// HapticLoop runs HapticTicks on its own thread: each millisecond it meets a surface, takes goals from the
// HapticPort, solves, and returns forces; the results go into the TickLog, a ring that another thread empties.
// become_realtime requests SCHED_FIFO and locked memory, and reports what was granted.
//
// Threads: the haptic thread, a loop's own, waits for no other: a late goal or force is missing, never waited
// for. A tick whose time has passed is skipped and counted.

#include <functional>
#include <glm/vec3.hpp>
#include <span>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {

/// A ring between one thread that writes and one that reads (single producer, single consumer). Neither
/// waits; all memory is allocated at the start.
template <class Slot>
class SpscRing {
public:
    explicit SpscRing(std::vector<Slot> slots) : slots_(std::move(slots)) {}

    /// Writer only: `fill` writes the next slot. False, and nothing is written, if the ring is full.
    /// Wait-free.
    template <class Fill>
    bool push(const Fill& fill) {
        const std::uint64_t at = pushed_.load(std::memory_order_relaxed);
        if (at - popped_.load(std::memory_order_acquire) == slots_.size()) return false;
        fill(slots_[at % slots_.size()]);
        pushed_.store(at + 1, std::memory_order_release);
        return true;
    }
    /// Reader only: the number of slots to pop.
    std::size_t waiting() const {
        return pushed_.load(std::memory_order_acquire) - popped_.load(std::memory_order_relaxed);
    }
    /// Reader only: passes the oldest slot to `consume`; false if there is none.
    template <class Consume>
    bool pop(const Consume& consume) {
        const std::uint64_t at = popped_.load(std::memory_order_relaxed);
        if (at == pushed_.load(std::memory_order_acquire)) return false;
        consume(slots_[at % slots_.size()]);
        popped_.store(at + 1, std::memory_order_release);
        return true;
    }

private:
    std::vector<Slot> slots_;
    alignas(64) std::atomic<std::uint64_t> pushed_{0};
    alignas(64) std::atomic<std::uint64_t> popped_{0};
};

/// Ticks on their way from the haptic thread to the thread that keeps them.
class TickLog {
public:
    TickLog(int ticks, int fingers);

    /// Haptic thread only. Copies the tick; false, and nothing is kept, if the ring is full. Wait-free.
    bool push(const TouchTick& tick);
    /// Reader only. Passes the oldest tick to `consume`; false if there is none.
    template <class Consume>
    bool pop(const Consume& consume) {
        return ring_.pop([&consume](const Slot& slot) { consume(slot.tick); });
    }

private:
    /// A tick, and its part of the log's memory, to which its spans refer.
    struct Slot {
        TouchTick tick;
        std::span<glm::dvec3> goals;
        std::span<Contact> contacts;
        std::span<GuardedForce> forces;
        std::span<double> shares;
    };
    std::vector<Slot> slots_for(int ticks, int fingers);

    // For all slots, consecutively: a log is made between two sessions of a hand, and each allocation takes
    // time.
    std::vector<glm::dvec3> goals_;
    std::vector<Contact> contacts_;
    std::vector<GuardedForce> forces_;
    std::vector<double> shares_;
    SpscRing<Slot> ring_;
};

/// The device side of the haptic thread: source of goals and sink of forces. Called every millisecond by that
/// thread only; must not wait. An exception counts as a failure.
class HapticPort {
public:
    virtual ~HapticPort() = default;
    /// Goals of a tick, world, scene units, one per finger. False: the device is gone, and the loop ends.
    virtual bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) = 0;
    /// Whether the hand lifted that goal over broken or rough ground (TouchStep::hops).
    virtual bool hops(std::size_t) const { return false; }
    /// Called before the goals of a tick after a gap of so many ms without ticks (longer than
    /// HapticLoop::longest_gap_ns). The hand may be anywhere by then, and another person's.
    virtual void come_back(std::int64_t) {}
    /// Guarded forces, newtons, world axes. False as above. The last call of a loop, however it ends, writes
    /// zeros.
    virtual bool write_forces(std::span<const glm::dvec3> newtons) = 0;
    /// Share of a finger's last written force that reached the hand: 0 to 1.
    virtual double share(std::size_t) const { return 1; }
};

/// The real-time features that this machine grants.
struct RealtimeGrant {
    /// Memory from which no page has to be loaded in a tick.
    enum class Memory {
        none,
        present,  ///< what existed at the request, as under a finite RLIMIT_MEMLOCK
        all       ///< and later memory, once it is touched
    };
    bool fifo = false;  ///< SCHED_FIFO
    Memory memory = Memory::none;
    std::optional<std::uint64_t> memory_limit{};  ///< RLIMIT_MEMLOCK, bytes; nothing: no effective limit
    int cpu = -1;                                 ///< the one CPU the thread stays on; -1: any
    std::string in_words() const;  ///< "SCHED_FIFO, memory locked, on CPU 1", or what is missing
};

/// SCHED_FIFO priority of the haptic thread: above ordinary real-time work, below the kernel's own.
inline constexpr int haptic_priority = 80;

/// Requests for the calling thread: SCHED_FIFO, the program's memory locked, pinned to the last of its CPUs
/// (interrupts tend to be served by the first) if there are several, timer slack 1 ns. Goes on without what
/// is refused.
RealtimeGrant become_realtime();

/// For a thread that carries a device's bytes: SCHED_FIFO like the haptic thread's, on any CPU. False: not
/// permitted.
bool become_fifo();

/// Sleeps until an absolute time of the monotonic clock.
void sleep_until(std::chrono::steady_clock::time_point moment);

/// The haptic thread: a tick every millisecond of the wall clock, each over the frames around its own time.
/// It never waits for another thread, never allocates; a tick that comes too late is counted and the missed
/// ones are skipped (docs/architecture.md, Threads).
class HapticLoop {
public:
    /// Facts about a run of the loop; complete after its end.
    struct Facts {
        RealtimeGrant grant;
        std::int64_t ticks = 0;
        std::int64_t late = 0;       ///< wake-ups a whole tick or more too late
        std::int64_t skipped = 0;    ///< ticks whose time had passed by then; never made up for
        std::int64_t gaps = 0;       ///< of more than `longest_gap_ns` without a tick
        std::int64_t lost = 0;       ///< ticks for which the log had no room
        double longest_port_ms = 0;  ///< longest time in the port in one tick, reading and writing together
        bool port_failed = false;    ///< it returned false, or threw
        bool broke_off = false;      ///< another exception in a tick: an internal error
    };
    /// TouchStep's longest gap. After a longer one, because the program was stopped, or the machine was
    /// suspended or busy, the next tick is met after a gap.
    static constexpr std::int64_t longest_gap_ns = TouchStep::longest_gap_ticks * tick_ns;
    /// All arguments outlive the loop; it is the only writer of `log`.
    HapticLoop(HapticTicks ticks, HapticPort& port, TickLog& log);
    ~HapticLoop();  ///< stops it
    HapticLoop(const HapticLoop&) = delete;
    HapticLoop& operator=(const HapticLoop&) = delete;

    /// Makes the loop end before that tick, even if no other thread can stop it. Before `start`.
    void end_before(std::int64_t tick) { end_ = tick; }
    /// Sets the clock for detecting gaps, in place of boot_ns: ns, never backward. Before `start`.
    void see_gaps_by(std::function<std::int64_t()> clock) { clock_ = std::move(clock); }
    /// Begins tick 0 now. A loop runs once: the state of its fingers
    /// knows nothing of a pause, and the hand would get a force without a ramp. An error on a second start,
    /// and if the machine has no thread left.
    Result<void> start();
    /// Ends after the tick in progress, with zero force written; no effect before the start or after the end.
    void stop();
    /// The same without waiting. Any thread.
    void ask_to_stop() { stopping_.store(true, std::memory_order_relaxed); }
    bool running() const { return !ended_.load(std::memory_order_acquire); }
    /// Time of the newest tick begun: tick k is at k ms.
    std::int64_t time_ns() const { return time_ns_.load(std::memory_order_relaxed); }
    /// When tick 0 was due; nothing before its thread has got there.
    std::optional<std::chrono::steady_clock::time_point> zero() const;
    /// After `stop`, or when it is no longer running.
    const Facts& facts() const { return facts_; }

private:
    static constexpr auto not_begun = std::chrono::steady_clock::time_point::min();

    void run();
    void tick_until_stopped();
    bool tick(std::int64_t tick, double late_us);
    bool finds_gap();

    const HapticTicks ticks_;
    HapticPort& port_;
    TickLog& log_;
    std::function<std::int64_t()> clock_ = boot_ns;
    std::int64_t ticked_ns_ = 0;  // time on that clock at the newest tick's beginning
    std::vector<glm::dvec3> newtons_;
    std::vector<double> shares_;
    Facts facts_;
    std::optional<std::int64_t> end_;
    bool started_ = false;
    std::atomic<bool> stopping_{false}, ended_{true};
    std::atomic<std::int64_t> time_ns_{0};
    std::atomic<std::chrono::steady_clock::time_point> zero_{not_begun};
    std::thread thread_;
};

}  // namespace touchable
