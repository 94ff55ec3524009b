#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "player/run/touch_session.hpp"

namespace touchable {

/// A finger in a tick.
struct WatchedFinger {
    glm::dvec3 goal{0.0};  ///< as the hand gave it
    Contact contact;       ///< the goal that was used, proxy, whether it touches, properties there
    GuardedForce force;    ///< as it was sent to the hand, and why it is not the spring's; no energy
};

struct WatchedTick {
    std::int64_t tick = -1;
    std::vector<WatchedFinger> fingers;
};

/// Of the ticks so far.
struct TickFigures {
    std::int64_t ticks = 0;
    std::int64_t late = 0;   ///< that began a millisecond or more too late
    double solve_us = 0;     ///< of the newest
    double late_us_p99 = 0;  ///< of all, in steps of 10; 1000 stands for all that were later
};

/// The newest tick, from the session's thread to a watcher's.
class WatchedTicks final : public TouchSink {
public:
    Result<void> take(const TouchTick& tick) override {
        const std::lock_guard lock(mutex_);
        figures_.late += tick.tick > newest_.tick + 1;
        ++figures_.ticks;
        figures_.solve_us = tick.solve_us;
        ++late_[std::min(static_cast<std::size_t>(std::max(tick.late_us, 0.0) / late_step_us),
                         late_.size() - 1)];
        newest_.tick = tick.tick;
        newest_.fingers.resize(tick.contacts.size());
        for (std::size_t k = 0; k < tick.contacts.size(); ++k)
            newest_.fingers[k] = {
                tick.goals[k], tick.contacts[k], {tick.sent(k), tick.forces[k].reasons, {}}};
        return {};
    }
    void copy_newest(WatchedTick& to) const {
        const std::lock_guard lock(mutex_);
        to = newest_;
    }
    TickFigures figures() const {
        const std::lock_guard lock(mutex_);
        TickFigures figures = figures_;
        std::int64_t later = 0;
        std::size_t step = late_.size();
        while (step > 0 && 100 * (later + late_[step - 1]) <= figures.ticks) later += late_[--step];
        figures.late_us_p99 = late_step_us * static_cast<double>(step);
        return figures;
    }

private:
    mutable std::mutex mutex_;
    WatchedTick newest_;
    TickFigures figures_;
    static constexpr double late_step_us = 10;
    std::array<std::int64_t, 100> late_{};  // ticks by how late they were
};

}  // namespace touchable
