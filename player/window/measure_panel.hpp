#pragma once

#include <vector>

#include "player/window/measure_tool.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// The panel's row for the tool, where Dear ImGui's cursor is. `scale` as in panel_rows.hpp.
void draw_measure(const MeasureFacts& facts, float scale, std::vector<WindowCommand>& asked);

/// The line and its length over the picture, below all panels.
void draw_measured_line(const MeasureFacts& facts, float scale);

}  // namespace touchable
