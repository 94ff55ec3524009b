#include "player/commands/touch_warnings.hpp"

#include <cstdint>
#include <cstdio>

namespace touchable {

namespace {

constexpr double bearable_skipped_pct = 1;

void add_live_warnings(const LiveFacts& live, std::int64_t frames, std::int64_t dropped,
                       std::vector<std::string> remarks, std::vector<std::string>& warnings) {
    if (!live.loop.grant.fifo)
        warnings.emplace_back(
            "no real-time scheduling (SCHED_FIFO is not permitted): ticks come late when the machine is "
            "busy");
    const auto skipped = static_cast<double>(live.loop.skipped);
    const double skipped_pct = 100 * skipped / (skipped + static_cast<double>(live.loop.ticks));
    if (skipped_pct > bearable_skipped_pct) {
        char share[32];
        std::snprintf(share, sizeof share, "%.1f %%", skipped_pct);
        warnings.push_back(share + std::string(" of the ticks were skipped, because others came too late"));
    }
    if (live.late_frames > 0)
        warnings.push_back(
            std::to_string(live.late_frames) + " of " + std::to_string(frames) +
            " frames came too late: decoding and building are too slow; touchable convert writes "
            "a clip that decodes faster");
    for (std::string& remark : remarks) warnings.push_back(std::move(remark));
    if (dropped > 0 && !live.camera)  // which leaves out some itself
        warnings.push_back(std::to_string(dropped) +
                           " frames were left out, because their time had passed before they were decoded");
}

}  // namespace

std::vector<std::string> touch_warnings(const nlohmann::ordered_json& report, const SurfaceFeed& feed,
                                        const LiveFacts* live, const std::string& why_no_position) {
    std::vector<std::string> warnings;
    if (live)
        add_live_warnings(*live, feed.frames(), feed.dropped_frames(), feed.reader().remarks(), warnings);
    if (!feed.any_valid())
        warnings.emplace_back(
            "100 % of the pixels are invalid: there is no surface; is depth.invalid of the scene right?");
    if (!why_no_position.empty())
        warnings.push_back(why_no_position);
    else if (report.at("contact_ticks") == 0)
        warnings.emplace_back("no finger touched anything");
    return warnings;
}

}  // namespace touchable
