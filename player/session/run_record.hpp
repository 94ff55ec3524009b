#pragma once

// What is kept and told of a run: the figures of its report, the facts that its recording keeps, and whether
// a replay's forces came out the same to the bit.
//
// TouchFigures is a sink of ticks: what is in the report of `touch` (docs/forces.md), and what a window shows
// at the end. recorded_facts makes the header of a run's recording, read_recorded_facts fills in a setup from
// it. A ReplayCheck compares each tick's forces with the recorded ones and remembers the first that differs;
// judge_replay puts it in words: the same, different from which tick and finger on, or not comparable.
//
// All of it belongs to the thread that takes a session's ticks.

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/run_files.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// Counts and sums of a run, in memory that does not grow with it, of forces as they were sent to the hand;
/// but the hash is of what the guard gave, which is what a replay gives again. Times are wall time on this
/// machine; everything else repeats to the bit.
class TouchFigures final : public TouchSink {
public:
    /// A finger's energy as it was sent: of each force only the share that went to the hand did work on it,
    /// and of the spring only that share was there. What is let through more or less is no motion of the
    /// hand's, and so counts as put in by the surface, as the guard's ramp does.
    class SentEnergy {
    public:
        /// Takes the guard's books up to a tick, and the share of its force that is sent and held. As long
        /// as all is sent, the figures are the guard's own to the bit.
        void take(const EnergyFigures& guarded, double share);
        const EnergyFigures& figures() const { return sent_; }

    private:
        EnergyFigures guarded_, kept_, sent_;  // kept back: guarded less sent
        double share_ = 1;                     // of the force that is held
    };

    Result<void> take(const TouchTick& tick) override;
    /// What comes is another run, by another guard: nothing goes on in a row.
    void end_part();

    std::int64_t ticks() const { return ticks_; }
    Spread tick_us() const { return tick_us_.spread(); }
    /// How late ticks began; all 0 in virtual time.
    Spread late_us() const { return late_us_.spread(); }
    /// Ticks by how late they began: {"below_us", "ticks"}, each counting what the ones before do not; the
    /// last has no "below_us".
    nlohmann::ordered_json late_histogram() const;
    std::string force_hash() const { return hash_.hex(); }
    /// Whether a hole's wall pushed a finger as hard as its device can.
    bool force_limited_in_holes() const { return limited_in_hole_ticks_ > 0; }
    /// Names are part of the interface: add to them, do not rename.
    nlohmann::ordered_json to_json() const;

private:
    EnergyFigures energy() const;  // of all fingers
    nlohmann::ordered_json energy_mj() const;
    nlohmann::ordered_json hole_contact() const;

    /// The fingers that were led somewhere, or touched.
    std::int64_t fingers_led() const;

    std::int64_t ticks_ = 0;
    std::vector<glm::dvec3> first_goals_;                        // of each finger, in this part
    std::vector<bool> led_;                                      // each finger, in any part
    std::int64_t contact_ticks_ = 0, finger_contact_ticks_ = 0;  // any finger; each finger
    std::int64_t behind_ticks_ = 0, nonfinite_ticks_ = 0, capped_ticks_ = 0, guarded_ticks_ = 0;
    std::int64_t stiffness_limited_ticks_ = 0, waiting_ticks_ = 0, stale_ticks_ = 0;
    // What the clip asked for in contact, N/m.
    double largest_stiffness_ = 0, smallest_stiffness_ = std::numeric_limits<double>::infinity();
    std::int64_t events_ = 0;
    double force_sum_ = 0, force_max_ = 0;  // over finger ticks in contact
    std::int64_t force_limited_ticks_ = 0,
                 longest_limited_ = 0;                   // finger ticks at the device's force; in a row
    std::vector<std::int64_t> limited_;                  // of each finger, in a row up to the newest tick
    std::int64_t hole_ticks_ = 0, longest_in_hole_ = 0;  // finger ticks on walls of holes; in a row
    std::int64_t limited_in_hole_ticks_ = 0;             // of these, at the device's force
    std::vector<std::int64_t> in_hole_;                  // as limited_
    std::int64_t held_back_ticks_ = 0;                   // finger ticks in contact, with less than all sent
    std::vector<SentEnergy> energy_;                     // of each finger, up to the newest tick
    EnergyFigures energy_before_;                        // of all fingers, in the parts before
    TimeSpread tick_us_, late_us_;
    static constexpr std::array late_below_us{10, 20, 50, 100, 200, 500, 1000};
    std::array<std::int64_t, late_below_us.size() + 1> late_ticks_{};  // the last: of all that were later
    ForceHash hash_;
};

/// What a recording keeps of a run that has ended beside its ticks (docs/touch.md), but for its forces'
/// hash.
nlohmann::ordered_json recorded_facts(const TouchSetup& setup);

/// The frames that the `planes_hash` of such facts is of; nothing where they do not say. Throws
/// std::out_of_range, with the member's name, where what they say cannot be.
std::optional<std::vector<FrameRun>> built_frames(const nlohmann::ordered_json& facts);

/// Fills in what those facts say of the run, but for what is opened and made of it, and gives the scene that
/// was touched. An error of kind input that begins with `name` where something is missing, of another kind or
/// impossible.
Result<SceneDescription> read_recorded_facts(const nlohmann::ordered_json& facts, const std::string& name,
                                             TouchSetup& setup);

/// Compares each tick with the recorded one, bit for bit, and remembers the first difference.
class ReplayCheck final : public TouchSink {
public:
    /// What the replay of a part came to.
    struct Outcome {
        int rules = 0;  ///< of force, that it was recorded under
        std::optional<std::string>
            difference;                 ///< what differs first: tick, finger, both values; nothing: none does
        bool has_other_frames = false;  ///< than those recorded
    };

    explicit ReplayCheck(const RecordedPart& recording) : recording_(recording) {}
    Result<void> take(const TouchTick& tick) override;
    /// After the last tick. `force_hash`: of the part's ticks.
    Outcome outcome(const std::string& force_hash, const TouchSetup& setup) const;

private:
    const RecordedPart& recording_;
    std::size_t next_ = 0;  // the tick that comes, by its place in the recording
    std::optional<std::string> difference_;
};

/// After a replay: an error of kind input where the recording was made under other rules of force, so that
/// there is nothing to compare; of kind check where something differs, which says what first and in which
/// part, and whether the clip's frames are others than those recorded. Else what there is to say: a clip may
/// have changed where no finger went. `force_hash`: of all parts.
Result<std::string> judge_replay(std::span<const ReplayCheck::Outcome> parts, const std::string& force_hash);

}  // namespace touchable
