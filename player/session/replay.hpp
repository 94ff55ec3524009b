#pragma once

// A recording played again, and whether its forces came out the same to the bit.
//
// read_recorded_facts reads what a recording's header says of its clip and settings. A ReplayHand gives its
// goals, a ReplayCheck compares each tick's forces and remembers the first that differs, judge_replay puts it
// in words: the same, different from which tick and finger on, or not comparable. The thread that takes a
// session's ticks.

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/hand.hpp"
#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"
#include "player/run/recording.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// What a recording keeps of a run that has ended beside its ticks (docs/recording.md), but for its forces'
/// hash.
nlohmann::ordered_json recorded_facts(const TouchSetup& setup);

/// Of which frames the `planes_hash` of such facts is; nothing where they do not say. Throws
/// std::out_of_range, with the member's name, where what they say cannot be.
std::optional<std::vector<FrameRun>> built_frames(const nlohmann::ordered_json& facts);

/// Fills in what those facts say of the run, but for what is opened and made of it, and gives the scene that
/// was touched. An error of kind input that begins with `name` where something is missing, of another kind or
/// impossible.
Result<SceneDescription> read_recorded_facts(const nlohmann::ordered_json& facts, const std::string& name,
                                             TouchSetup& setup);

/// `--replay FILE`: the recorded goals as a hand.
class ReplayHand final : public Hand {
public:
    explicit ReplayHand(const RecordedPart& recording) : recording_(recording) {}
    int fingers() const override { return recording_.fingers; }
    void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) override;
    std::optional<std::int64_t> ticks() const override {
        return static_cast<std::int64_t>(recording_.ticks.size());
    }

private:
    const RecordedPart& recording_;
};

/// Compares each tick with the recorded one, bit for bit, and remembers the first difference.
class ReplayCheck final : public TouchSink {
public:
    explicit ReplayCheck(const RecordedPart& recording) : recording_(recording) {}
    Result<void> take(const TouchTick& tick) override;
    /// What differs first: tick, finger, and both values; nothing where all is the same.
    const std::optional<std::string>& difference() const { return difference_; }

private:
    const RecordedPart& recording_;
    std::size_t next_ = 0;  // the tick that comes, by its place in the recording
    std::optional<std::string> difference_;
};

/// What the replay of a part came to.
struct ReplayedPart {
    int rules = 0;                          ///< of force, that it was recorded under
    std::optional<std::string> difference;  ///< what differs first
    bool has_other_frames = false;          ///< than those recorded
};
ReplayedPart compare_replay(const RecordedPart& recorded, const ReplayCheck& check,
                            const std::string& force_hash, const TouchSetup& setup);

/// After a replay: an error of kind input where the recording was made under other rules of force, so that
/// there is nothing to compare; of kind check where something differs, which says what first and in which
/// part, and whether the clip's frames are others than those recorded. Else what there is to say: a clip may
/// have changed where no finger went. `force_hash`: of all parts.
Result<std::string> judge_replay(std::span<const ReplayedPart> parts, const std::string& force_hash);

}  // namespace touchable
