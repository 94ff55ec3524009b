#include "player/session/replay.hpp"

#include <algorithm>
#include <cstring>

#include "engine/base/number_words.hpp"
#include "haptics_cpu/force_rules.hpp"
#include "player/run/planes_hash.hpp"
#include "player/session/recorded_facts.hpp"

namespace touchable {

namespace {

bool same_bits(const glm::dvec3& a, const glm::dvec3& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

std::string to_text(const glm::dvec3& force, std::uint32_t guard) {
    return formatted("(%.17g, %.17g, %.17g) N with guard %u", force.x, force.y, force.z, guard);
}

/// A live session reads ahead of its hand as far as its builder gets, so that its replay reads fewer frames:
/// what was recorded says of how many its hash is. A live recording of a version that did not say tells
/// nothing.
bool has_other_frames(const RecordedPart& recording, const TouchSetup& setup) {
    const auto recorded = recording.facts.at("planes_hash").get<std::string>();
    const auto built = built_frames(recording.facts);
    if (!built) return !setup.live && recorded != setup.feed->planes_hash();
    if (*built == setup.feed->built()) return recorded != setup.feed->planes_hash();
    const auto reader = setup.clip.open(Colour::left_out);
    if (!reader.ok()) return true;
    const auto found = planes_hash_of(**reader, *built);
    return !found.ok() || *found != recorded;
}

std::string in_words(std::uint64_t epoch, std::int64_t prev, std::int64_t next, double blend) {
    std::string words = formatted("between frames %lld and %lld at %.17g", static_cast<long long>(prev),
                                  static_cast<long long>(next), blend);
    if (epoch > 0) words += " of epoch " + std::to_string(epoch);
    return words;
}

}  // namespace

void ReplayHand::goals_at(std::int64_t tick, const SurfaceProbe&, std::span<glm::dvec3> goals) {
    const RecordedTick& recorded = recording_.ticks[static_cast<std::size_t>(tick)];
    std::copy(recorded.goals.begin(), recorded.goals.end(), goals.begin());
}

Result<void> ReplayCheck::take(const TouchTick& tick) {
    if (difference_) return {};
    const RecordedTick& recorded = recording_.ticks[next_++];
    const std::string where = "tick " + std::to_string(tick.tick);
    if (recorded.frame_prev != tick.pair.prev.number || recorded.frame_next != tick.pair.next.number ||
        recorded.blend != tick.blend || recorded.epoch != tick.pair.epoch) {
        difference_ = where + ": " +
                      in_words(tick.pair.epoch, tick.pair.prev.number, tick.pair.next.number, tick.blend) +
                      ", recorded " +
                      in_words(recorded.epoch, recorded.frame_prev, recorded.frame_next, recorded.blend);
        return {};
    }
    for (std::size_t k = 0; k < tick.forces.size(); ++k) {
        if (same_bits(recorded.forces[k], tick.forces[k].force) &&
            recorded.guards[k] == tick.forces[k].reasons)
            continue;
        difference_ = where + ", finger " + std::to_string(k) + ": force " +
                      to_text(tick.forces[k].force, tick.forces[k].reasons) + ", recorded " +
                      to_text(recorded.forces[k], recorded.guards[k]);
        return {};
    }
    return {};
}

ReplayedPart compare_replay(const RecordedPart& recorded, const ReplayCheck& check,
                            const std::string& force_hash, const TouchSetup& setup) {
    ReplayedPart part{recorded.rules(), check.difference(), has_other_frames(recorded, setup)};
    const auto hash = recorded.facts.at("force_hash").get<std::string>();
    if (!part.difference && hash != force_hash)
        part.difference = "force_hash " + force_hash + ", recorded " + hash;
    return part;
}

Result<std::string> judge_replay(std::span<const ReplayedPart> parts, const std::string& force_hash) {
    bool others = false;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const ReplayedPart& part = parts[k];
        if (part.rules != force_rules)
            return input_error("replay is not comparable: made under rules " + std::to_string(part.rules) +
                               " of force, this program has rules " + std::to_string(force_rules) +
                               "; what was asked for is written, with its forces");
        others = others || part.has_other_frames;
        const std::string where = parts.size() > 1 ? "part " + std::to_string(k + 1) + ", " : "";
        if (part.difference)
            return Error{ErrorKind::check,
                         "replay differs first at " + where + *part.difference +
                             (part.has_other_frames ? "; the clip's frames are not the recorded ones" : "")};
    }
    const std::string all = parts.size() > 1 ? " in all " + std::to_string(parts.size()) + " parts" : "";
    return "replay: every force is as recorded, to the bit" + all + " (" + force_hash + ")\n" +
           (others ? "note: the clip's frames are not the recorded ones; they differ where no finger "
                     "felt it\n"
                   : "");
}

}  // namespace touchable
