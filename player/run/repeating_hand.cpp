#include "player/run/repeating_hand.hpp"

#include <algorithm>
#include <array>

#include "device/hand_options.hpp"
#include "engine/base/try.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

namespace {

constexpr std::array keys{HandKey{"depth", "mm", 0, 50}};

/// Where the options begin in "FILE[:key=value]": a file's name may hold ':'.
std::size_t options_colon(std::string_view description) {
    const std::size_t equals = description.rfind('=');
    return equals == std::string_view::npos ? equals : description.rfind(':', equals);
}

double scale_of(const RecordedPart& part) {
    const auto& facts = part.facts;
    return facts.contains("S") && facts["S"].is_number() ? facts["S"].get<double>() : 0;
}

/// The ticks of all parts, each after the one before.
RecordedPart in_one(Recording recording) {
    RecordedPart all = std::move(recording.front());
    for (std::size_t k = 1; k < recording.size(); ++k) {
        const std::int64_t begin_ns = (all.ticks.back().time_ns / tick_ns + 1) * tick_ns;
        for (RecordedTick& tick : recording[k].ticks) {
            tick.time_ns += begin_ns;
            all.ticks.push_back(std::move(tick));
        }
    }
    return all;
}

}  // namespace

Result<std::unique_ptr<RepeatingHand>> RepeatingHand::read(const std::string& hand) {
    const std::string_view description = std::string_view(hand).substr(std::string_view("rec:").size());
    const std::size_t colon = options_colon(description);
    std::string file(description.substr(0, colon));
    if (file.empty())
        return usage_error("hand 'rec': no file; right would be rec:FILE, a recording of a run",
                           {{Setting::hand}, {Setting::record}});
    const auto given = HandOptions::parse(
        "hand 'rec'", colon == std::string_view::npos ? "" : description.substr(colon + 1), keys);
    if (!given.ok()) return given.error();
    TRY_ASSIGN(auto recording, read_recording(file));
    const double metres = scale_of(recording.front());
    for (const RecordedPart& part : recording) {
        if (!(scale_of(part) > 0))
            return input_error(part.name +
                               ": does not say above 0 how far a device moves per scene unit (S)");
        if (scale_of(part) != metres)
            return input_error(part.name + ": a device moves otherwise per scene unit (S) than in part 1");
    }
    RecordedPart whole = in_one(std::move(recording));
    std::optional<double> deepest;
    if (given->given("depth")) deepest = given->number("depth") * 0.001;
    return std::unique_ptr<RepeatingHand>(
        new RepeatingHand(std::move(file), std::move(whole), metres, GoalWatch(metres, deepest)));
}

void RepeatingHand::goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) {
    const auto& ticks = recording_.ticks;
    if (tick == 0) at_ = 0;
    while (at_ + 1 < ticks.size() && ticks[at_ + 1].time_ns <= tick * tick_ns) ++at_;
    std::copy(ticks[at_].goals.begin(), ticks[at_].goals.end(), goals.begin());
    watch_.look(probe, goals);
}

std::optional<std::int64_t> RepeatingHand::ticks() const {
    return recording_.ticks.back().time_ns / tick_ns + 1;
}

}  // namespace touchable
