#include "haptics_cpu/tick_log.hpp"

#include <algorithm>

namespace touchable {

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

}  // namespace touchable
