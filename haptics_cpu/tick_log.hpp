#pragma once

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
    /// A tick with memory of its own, to which its spans refer.
    struct Slot {
        TouchTick tick;
        std::vector<glm::dvec3> goals;
        std::vector<Contact> contacts;
        std::vector<GuardedForce> forces;
        std::vector<double> shares;
    };
    static std::vector<Slot> slots_for(int ticks, int fingers);

    SpscRing<Slot> ring_;
};

}  // namespace touchable
