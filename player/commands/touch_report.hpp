#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "player/draw/surface_painter.hpp"
#include "player/run/live_session.hpp"
#include "player/session/touch_figures.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// What a run came to (docs/forces.md). `live`: how the session on the wall clock went, nullptr for one of
/// virtual time; `painter`: the picture's, if there is one. Names are part of the interface: add to them, do
/// not rename.
nlohmann::ordered_json make_report(const TouchSetup& setup, const TouchFigures& figures,
                                   const LiveFacts* live, const SurfacePainter* painter);
/// Of a replay of several parts: what `all` figures say of them together, and in "parts" the report of each.
nlohmann::ordered_json join_reports(const std::vector<nlohmann::ordered_json>& parts,
                                    const TouchFigures& all);
/// The same as a table for a person; of several parts each after the other.
std::string report_to_text(const nlohmann::ordered_json& report);
/// What most people want to know of it: warnings, what was touched, the force, whether it is sound, and where
/// the figures are. `files`: those that were written; nothing where none was asked for.
std::string report_in_short(const nlohmann::ordered_json& report,
                            const std::optional<std::vector<std::string>>& files);

}  // namespace touchable
