#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "haptics_cpu/touch_tick.hpp"

namespace touchable {

/// Ticks on their way from the haptic thread to whoever keeps them: a ring between one writer and one reader.
/// Neither waits; all memory is there from the start.
class TickLog {
public:
    TickLog(int ticks, int fingers);

    /// Haptic thread. Copies the tick; false, and nothing kept, while the ring is full. Wait-free.
    bool push(const TouchTick& tick);
    /// Reader. Hands the oldest tick to `take`; false where there is none.
    template <class Take>
    bool pop(Take take) {
        const std::uint64_t at = popped_.load(std::memory_order_relaxed);
        if (at == pushed_.load(std::memory_order_acquire)) return false;
        take(slots_[at % slots_.size()].tick);
        popped_.store(at + 1, std::memory_order_release);
        return true;
    }

private:
    /// A tick with memory of its own, to which its spans refer.
    struct Slot {
        TouchTick tick;
        std::vector<glm::dvec3> goals;
        std::vector<Contact> contacts;
        std::vector<GuardedForce> forces;
    };
    std::vector<Slot> slots_;
    alignas(64) std::atomic<std::uint64_t> pushed_{0};
    alignas(64) std::atomic<std::uint64_t> popped_{0};
};

}  // namespace touchable
