#include "player/session/repeating_hand.hpp"

#include <algorithm>
#include <array>

#include "device/hand_options.hpp"
#include "player/session/touch_session.hpp"

namespace touchable {

namespace {

constexpr std::array keys{HandKey{"depth", "mm", 0, 50}};

/// Where the options begin in "FILE[:key=value]": a file's name may hold ':'.
std::size_t options_colon(std::string_view description) {
    const std::size_t equals = description.rfind('=');
    return equals == std::string_view::npos ? equals : description.rfind(':', equals);
}

}  // namespace

Result<std::unique_ptr<RepeatingHand>> RepeatingHand::read(const std::string& hand) {
    const std::string_view description = std::string_view(hand).substr(std::string_view("rec:").size());
    const std::size_t colon = options_colon(description);
    std::string file(description.substr(0, colon));
    if (file.empty())
        return usage_error("hand 'rec': no file; right would be rec:FILE, which --record wrote");
    const auto given = HandOptions::parse(
        "hand 'rec'", colon == std::string_view::npos ? "" : description.substr(colon + 1), keys);
    if (!given.ok()) return given.error();
    auto recording = read_recording(file);
    if (!recording.ok()) return recording.error();
    const auto& facts = recording->facts;
    const double metres = facts.contains("S") && facts["S"].is_number() ? facts["S"].get<double>() : 0;
    if (!(metres > 0))
        return input_error("recording " + file +
                           ": does not say above 0 how far a device moves per scene unit (S)");
    std::optional<double> deepest;
    if (given->given("depth")) deepest = given->number("depth") * 0.001;
    return std::unique_ptr<RepeatingHand>(
        new RepeatingHand(std::move(file), std::move(*recording), metres, GoalWatch(metres, deepest)));
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
