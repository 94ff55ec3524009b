#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "player/run/live_session.hpp"
#include "player/run/surface_feed.hpp"

namespace touchable {

/// What should worry a person about a run, each a line: a report's figures say that it is not what was meant,
/// or was not felt as it should be. `live`: nullptr for a run of virtual time. `why_no_position`: why the
/// device that was held never had a position; empty: it had one, or none was held.
std::vector<std::string> touch_warnings(const nlohmann::ordered_json& report, const SurfaceFeed& feed,
                                        const LiveFacts* live, const std::string& why_no_position);

}  // namespace touchable
