// SPDX-License-Identifier: Apache-2.0
#pragma once

// Figures of a run. A TouchSink receives every tick; TouchFigures is the one that counts and sums them, for
// the report of `touch` (docs/forces.md) and of a window's end. TimeSpread keeps how measured times are
// spread.

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/base/result.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {

/// Receives every tick: figures, a file of forces, a recording, a comparison.
class TouchSink {
public:
    virtual ~TouchSink() = default;
    virtual Result<void> consume(const TouchTick& tick) = 0;
};

/// Spread of a measured quantity.
struct Spread {
    double mean = 0, p50 = 0, p99 = 0, p999 = 0, max = 0;
};
nlohmann::ordered_json to_json(const Spread& spread);

/// Spread of any number of times in constant memory: a histogram whose bins grow with the time, 128 per power
/// of 2. Mean and max are exact, the quantiles within half a percent (below 1/1024 of the times' unit: within
/// 1/1024).
class TimeSpread {
public:
    TimeSpread();
    /// `time`: any unit, 0 or more.
    void add(double time);
    /// In the same unit; all 0 if empty.
    Spread spread() const;

private:
    double quantile(double share) const;

    std::vector<std::int64_t> times_;  // count per bin
    std::int64_t count_ = 0;
    double sum_ = 0, least_ = 0, most_ = 0;
};

/// Counts and sums of a run, of the forces as sent to the hand, in constant memory. The hash alone covers the
/// guard's forces, which a replay reproduces. Times are wall time on this machine; everything else repeats to
/// the bit.
class TouchFigures final : public TouchSink {
public:
    /// A finger's energy as sent: only the sent share of each force does work on the hand, and only that
    /// share of the spring stores energy. A change of the share is not the hand's motion, so its energy
    /// counts as put in by the surface, like the guard's ramp.
    class SentEnergy {
    public:
        /// Takes the guard's energy figures up to a tick and the share of its force that is sent and held.
        /// While the share is 1 the figures equal the guard's to the bit.
        void update(const EnergyFigures& guarded, double share);
        const EnergyFigures& figures() const { return sent_; }

    private:
        EnergyFigures guarded_, kept_, sent_;  // kept back: guarded less sent
        double share_ = 1;                     // share of the force now held
    };

    Result<void> consume(const TouchTick& tick) override;
    /// Next ticks are of another run with another guard: ends all rows of consecutive ticks.
    void end_part();

    std::int64_t ticks() const { return ticks_; }
    Spread tick_us() const { return tick_us_.spread(); }
    /// How late ticks began, us; all 0 in virtual time.
    Spread late_us() const { return late_us_.spread(); }
    /// Ticks by how late they began: {"below_us", "ticks"}; each bin starts where the previous ends, the last
    /// has no "below_us".
    nlohmann::ordered_json late_histogram() const;
    std::string force_hash() const { return hash_.hex(); }
    /// Whether a hole's wall pushed a finger as hard as its device can.
    bool force_limited_in_holes() const { return limited_in_hole_ticks_ > 0; }
    /// Names are part of the interface: add to them, do not rename.
    nlohmann::ordered_json to_json() const;

private:
    EnergyFigures energy() const;  // of all fingers
    nlohmann::ordered_json energy_mj() const;

    /// Number of fingers that were moved or touched.
    std::int64_t fingers_led() const { return std::ranges::count(led_, true); }

    /// A finger in this part, up to the newest tick.
    struct Finger {
        glm::dvec3 first_goal;
        bool hopping = false;
        std::int64_t limited = 0, in_hole = 0;  // length of the current run at the device's force; of a hole
        SentEnergy energy{};
    };

    std::int64_t ticks_ = 0;
    std::vector<Finger> fingers_;
    std::vector<bool> led_;  // per finger, in any part
    std::int64_t hops_ = 0;
    std::int64_t contact_ticks_ = 0, finger_contact_ticks_ = 0;  // ticks, finger ticks in contact
    std::int64_t behind_ticks_ = 0, nonfinite_ticks_ = 0, capped_ticks_ = 0, guarded_ticks_ = 0;
    std::int64_t stiffness_limited_ticks_ = 0, waiting_ticks_ = 0, stale_ticks_ = 0;
    // The clip's stiffness in contact, N/m.
    double largest_stiffness_ = 0, smallest_stiffness_ = std::numeric_limits<double>::infinity();
    std::int64_t events_ = 0;
    double force_sum_ = 0, force_max_ = 0;  // over finger ticks in contact
    std::int64_t force_limited_ticks_ = 0,
                 longest_limited_ = 0;                   // finger ticks at the device's force; longest run
    std::int64_t hole_ticks_ = 0, longest_in_hole_ = 0;  // finger ticks on walls of holes; longest run
    std::int64_t limited_in_hole_ticks_ = 0;             // of these, at the device's force
    std::int64_t held_back_ticks_ = 0;                   // finger ticks in contact, with less than all sent
    EnergyFigures energy_before_;                        // of all fingers, in the parts before
    TimeSpread tick_us_, late_us_;
    static constexpr std::array late_below_us{10, 20, 50, 100, 200, 500, 1000};
    std::array<std::int64_t, late_below_us.size() + 1> late_ticks_{};  // the last: all later ticks
    ForceHash hash_;
};

}  // namespace touchable
