#include "haptics_cpu/tick_log.hpp"

#include <algorithm>

namespace touchable {

TickLog::TickLog(int ticks, int fingers) : ring_(slots_for(ticks, fingers)) {}

std::vector<TickLog::Slot> TickLog::slots_for(int ticks, int fingers) {
    std::vector<Slot> slots(static_cast<std::size_t>(ticks));
    const auto count = static_cast<std::size_t>(fingers);
    for (Slot& slot : slots) {
        slot.goals.resize(count);
        slot.contacts.resize(count);
        slot.forces.resize(count);
        slot.shares.resize(count);
    }
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

}  // namespace touchable
