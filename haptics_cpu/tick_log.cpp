#include "haptics_cpu/tick_log.hpp"

#include <algorithm>

namespace touchable {

TickLog::TickLog(int ticks, int fingers) : slots_(static_cast<std::size_t>(ticks)) {
    const auto count = static_cast<std::size_t>(fingers);
    for (Slot& slot : slots_) {
        slot.goals.resize(count);
        slot.contacts.resize(count);
        slot.forces.resize(count);
    }
}

bool TickLog::push(const TouchTick& tick) {
    const std::uint64_t at = pushed_.load(std::memory_order_relaxed);
    if (at - popped_.load(std::memory_order_acquire) == slots_.size()) return false;
    Slot& slot = slots_[at % slots_.size()];
    slot.tick = tick;
    std::copy(tick.goals.begin(), tick.goals.end(), slot.goals.begin());
    std::copy(tick.contacts.begin(), tick.contacts.end(), slot.contacts.begin());
    std::copy(tick.forces.begin(), tick.forces.end(), slot.forces.begin());
    slot.tick.goals = slot.goals;
    slot.tick.contacts = slot.contacts;
    slot.tick.forces = slot.forces;
    pushed_.store(at + 1, std::memory_order_release);
    return true;
}

}  // namespace touchable
