#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "player/session/live_session.hpp"
#include "player/session/touch_figures.hpp"
#include "player/session/touch_setup.hpp"
#include "player/view/surface_painter.hpp"

namespace touchable {

/// What a run came to (docs/forces.md). `live`: how the session on the wall clock went, nullptr for one of
/// virtual time; `painter`: the picture's, if there is one. Names are part of the interface: add to them, do
/// not rename.
nlohmann::ordered_json make_report(const TouchSetup& setup, const TouchFigures& figures,
                                   const LiveFacts* live, const SurfacePainter* painter);
/// The same as lines for a person.
std::string report_to_text(const nlohmann::ordered_json& report);

}  // namespace touchable
