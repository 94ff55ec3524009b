// SPDX-License-Identifier: Apache-2.0
#include "haptics_cpu/haptic_loop.hpp"

#include <link.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>
#include <cerrno>

namespace touchable {

namespace {

using std::chrono::steady_clock;
using Memory = RealtimeGrant::Memory;

std::string memory_in_words(const RealtimeGrant& grant) {
    if (grant.memory == Memory::all) return "memory locked";
    const std::string limit = grant.memory_limit
                                  ? "RLIMIT_MEMLOCK is " + std::to_string(*grant.memory_limit / 1024) + " KiB"
                                  : "not permitted";
    if (grant.memory == Memory::none) return "memory not locked (" + limit + ")";
    return "memory locked but what came after the start (" + limit + ")";
}

/// Whether memory may be locked beyond a limit, as with CAP_IPC_LOCK: tried on addresses without memory.
bool may_lock_beyond(std::uint64_t limit) {
    const std::size_t bytes = limit + (std::size_t{1} << 20);
    void* nothing = mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (nothing == MAP_FAILED) return false;
    const bool may = mlock2(nothing, bytes, MLOCK_ONFAULT) == 0;
    munmap(nothing, bytes);
    return may;
}

/// How much memory this process may lock, after raising the limit as far as allowed; nothing: no limit.
std::optional<std::uint64_t> memory_limit() {
    rlimit limit{};
    getrlimit(RLIMIT_MEMLOCK, &limit);
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_MEMLOCK, &limit);
    if (limit.rlim_cur == RLIM_INFINITY || may_lock_beyond(limit.rlim_cur)) return std::nullopt;
    return limit.rlim_cur;
}

/// Loads and locks code and data of the program, which has no name here, and of the libraries that a tick may
/// call, so that no tick waits for them.
int lock_for_ticks(dl_phdr_info* object, std::size_t, void*) {
    const std::string_view name = object->dlpi_name;
    const auto is_part = [name](const char* library) { return name.find(library) != std::string_view::npos; };
    if (!name.empty() && !is_part("/libc.so") && !is_part("/libm.so") && !is_part("/libstdc++.so")) return 0;
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    for (int k = 0; k < object->dlpi_phnum; ++k) {
        const auto& segment = object->dlpi_phdr[k];
        if (segment.p_type != PT_LOAD) continue;
        const std::uintptr_t begin = (object->dlpi_addr + segment.p_vaddr) / page * page;
        const std::uintptr_t end = object->dlpi_addr + segment.p_vaddr + segment.p_memsz;
        mlock(reinterpret_cast<const void*>(begin), end - begin);
    }
    return 0;
}

/// Touches as much of the calling thread's stack as a tick could need.
unsigned char touch_stack() {
    constexpr std::size_t depth = 256 * 1024, page = 4096;
    volatile unsigned char below[depth];
    for (std::size_t at = 0; at < depth; at += page) below[at] = 0;
    return below[0];
}

/// Locks present memory, and later memory once it is touched, as builders touch their frames before the hand
/// gets them: loading all of it at once would load what drivers and libraries only reserve, and eight
/// megabytes of stack per thread. Under a finite limit later memory is not locked, because memory beyond the
/// limit would be refused altogether.
Memory lock_memory(bool limited) {
    if (mlockall(MCL_CURRENT | MCL_ONFAULT) != 0) return Memory::none;
    dl_iterate_phdr(lock_for_ticks, nullptr);
    touch_stack();
    if (limited || mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) return Memory::present;
    return Memory::all;
}

/// Pins the calling thread to its last CPU, and returns it; -1 if it has only one, or may not choose.
int stay_on_last_cpu() {
    cpu_set_t allowed;
    if (pthread_getaffinity_np(pthread_self(), sizeof(allowed), &allowed) != 0 || CPU_COUNT(&allowed) < 2)
        return -1;
    int last = CPU_SETSIZE - 1;
    while (!CPU_ISSET(last, &allowed)) --last;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(last, &one);
    return pthread_setaffinity_np(pthread_self(), sizeof(one), &one) == 0 ? last : -1;
}

constexpr std::chrono::milliseconds tick_time(1);

/// The answer of a port; an exception counts as a failure.
template <class Call>
bool answer_of(Call&& call) noexcept {
    try {
        return call();
    } catch (...) {
        return false;
    }
}

}  // namespace

TickLog::TickLog(int ticks, int fingers) : ring_(slots_for(ticks, fingers)) {}

std::vector<TickLog::Slot> TickLog::slots_for(int ticks, int fingers) {
    const auto count = static_cast<std::size_t>(fingers);
    std::vector<Slot> slots(static_cast<std::size_t>(ticks));
    const auto share_out = [&](auto& all, auto part) {
        all.resize(slots.size() * count);
        for (std::size_t k = 0; k < slots.size(); ++k)
            slots[k].*part = std::span(all).subspan(k * count, count);
    };
    share_out(goals_, &Slot::goals);
    share_out(contacts_, &Slot::contacts);
    share_out(forces_, &Slot::forces);
    share_out(shares_, &Slot::shares);
    return slots;
}

bool TickLog::push(const TouchTick& tick) {
    return ring_.push([&tick](Slot& slot) {
        slot.tick = tick;
        std::copy(tick.goals.begin(), tick.goals.end(), slot.goals.begin());
        std::copy(tick.contacts.begin(), tick.contacts.end(), slot.contacts.begin());
        std::copy(tick.forces.begin(), tick.forces.end(), slot.forces.begin());
        slot.tick.goals = slot.goals;
        slot.tick.contacts = slot.contacts;
        slot.tick.forces = slot.forces;
        std::copy(tick.shares.begin(), tick.shares.end(), slot.shares.begin());
        if (!tick.shares.empty()) slot.tick.shares = slot.shares;
    });
}

std::string RealtimeGrant::in_words() const {
    const std::string scheduling = fifo ? "SCHED_FIFO" : "normal scheduling (SCHED_FIFO is not permitted)";
    return scheduling + ", " + memory_in_words(*this) +
           (cpu >= 0 ? ", on CPU " + std::to_string(cpu) : ", on any CPU");
}

bool become_fifo() {
    sched_param priority{};
    priority.sched_priority = haptic_priority;
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
}

RealtimeGrant become_realtime() {
    RealtimeGrant grant;
    grant.fifo = become_fifo();
    grant.memory_limit = memory_limit();
    grant.memory = lock_memory(grant.memory_limit.has_value());
    grant.cpu = stay_on_last_cpu();
    prctl(PR_SET_TIMERSLACK, 1UL);
    return grant;
}

void sleep_until(std::chrono::steady_clock::time_point moment) {
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(moment.time_since_epoch()).count();
    const timespec when{ns / 1'000'000'000, ns % 1'000'000'000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &when, nullptr) == EINTR) {
    }
}

HapticLoop::HapticLoop(HapticTicks ticks, HapticPort& port, TickLog& log)
    : ticks_(std::move(ticks)),
      port_(port),
      log_(log),
      newtons_(ticks_.goals.size()),
      shares_(ticks_.goals.size()) {}

HapticLoop::~HapticLoop() {
    stop();
}

Result<void> HapticLoop::start() {
    if (started_) return Error{ErrorKind::internal, "a haptic loop runs once; make another"};
    ended_.store(false, std::memory_order_release);
    auto begun = start_thread(thread_, "haptic-loop", "of the hand", [this] { run(); });
    started_ = bool(begun);
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

/// No exception leaves the thread, and on every exit the hand is left with zero force.
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

/// Uses a clock that goes on while the machine is suspended. (Ticks stand still then, as the clip does.)
bool HapticLoop::finds_gap() {
    const std::int64_t now = clock_(), alone_ns = now - std::exchange(ticked_ns_, now);
    if (alone_ns <= longest_gap_ns) return false;
    ++facts_.gaps;
    port_.come_back(alone_ns / 1'000'000);
    return true;
}

bool HapticLoop::tick(std::int64_t tick, double late_us) {
    time_ns_.store(std::chrono::nanoseconds(tick * tick_time).count(), std::memory_order_relaxed);
    const HeightField field = ticks_.meet(tick, finds_gap());
    const auto asked = steady_clock::now();
    if (!answer_of([&] { return port_.read_goals(tick, field, ticks_.goals); })) return false;
    const auto read = steady_clock::now();
    for (std::size_t k = 0; k < newtons_.size(); ++k) ticks_.hops[k] = port_.hops(k);
    TouchTick done = ticks_.solve();
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
