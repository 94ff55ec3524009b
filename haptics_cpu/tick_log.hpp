#pragma once

#include <span>
#include <vector>

#include "haptics_cpu/spsc_ring.hpp"
#include "haptics_cpu/touch_tick.hpp"

namespace touchable {

/// Ticks on their way from the haptic thread to whoever keeps them.
class TickLog {
public:
    TickLog(int ticks, int fingers);

    /// Haptic thread. Copies the tick; false, and nothing kept, while the ring is full. Wait-free.
    bool push(const TouchTick& tick);
    /// Reader. Hands the oldest tick to `take`; false where there is none.
    template <class Take>
    bool pop(const Take& take) {
        return ring_.pop([&take](const Slot& slot) { take(slot.tick); });
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

    // Of all slots, one after the other: a log is made between two sessions of a hand, and each piece of
    // memory takes its time.
    std::vector<glm::dvec3> goals_;
    std::vector<Contact> contacts_;
    std::vector<GuardedForce> forces_;
    std::vector<double> shares_;
    SpscRing<Slot> ring_;
};

}  // namespace touchable
