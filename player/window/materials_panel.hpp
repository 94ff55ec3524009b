#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "player/window/brush_tool.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// What is shown of the brush of materials.
struct BrushFacts {
    BrushTool tool = BrushTool::touch;
    std::string material{};         ///< in hand
    bool is_there = false;          ///< segments are known
    std::string otherwise{};        ///< material of all that nobody painted; empty: guesses
    bool materials_are_on = false;  ///< felt
    bool can_undo = false, can_redo = false;
    std::size_t segments = 0;        ///< that are seen anywhere in the clip
    std::vector<glm::dvec2> line{};  ///< that was begun, pixels of the window
};

/// The panel's part for it, a row each, where Dear ImGui's cursor is. `scale` as in panel_rows.hpp.
void draw_materials(const BrushFacts& facts, float scale, std::vector<WindowCommand>& asked);

/// The line that was begun, over the picture and below all panels.
void draw_brush_line(const BrushFacts& facts, float scale);

}  // namespace touchable
