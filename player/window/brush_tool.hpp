#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/authoring/segment_names.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// What the left button does over the picture.
enum class BrushTool {
    touch,  ///< it presses the finger
    paint,  ///< the segment that is clicked gets the material in hand
    join,   ///< the segment that is clicked first and the next one are one
    cut     ///< a stroke that is dragged parts its segment
};
/// As commands and the panel call it.
const char* name_of(BrushTool tool);
/// All of them, as the panel shows them.
std::span<const BrushTool> brush_tools();
/// Nothing where it is none's name.
std::optional<BrushTool> brush_tool_of(std::string_view name);

/// The brush in a person's hand: what clicks and drags with it come to, as commands.
class HeldBrush {
public:
    static constexpr std::size_t most_points = 4096;  ///< of a stroke

    BrushTool tool() const { return tool_; }
    bool is_held() const { return tool_ != BrushTool::touch; }
    /// What was begun with the one before is let go of.
    void take(BrushTool tool);
    /// Away, or the last one again; the first is paint.
    void take_or_put_away() { take(is_held() ? BrushTool::touch : last_); }
    const std::string& material() const { return material_; }
    void set_material(std::string material) { material_ = std::move(material); }

    /// A place of the window, pixels, and what of the clip is seen there.
    struct Place {
        glm::dvec2 at{0.0};
        std::optional<PixelOfFrame> pixel{};  ///< nothing: no surface
    };
    /// The left button; what that asks for.
    std::optional<WindowCommand> press(const Place& place);
    /// The pointer, pressed or not.
    void move(const Place& place);
    std::optional<WindowCommand> release();
    /// Nothing is begun any more.
    void let_go();
    /// Whether the first of two segments was clicked.
    bool has_first() const { return tool_ == BrushTool::join && !places_.empty(); }
    /// Whether a stroke is being drawn.
    bool is_drawing() const { return is_drawing_; }
    /// What was begun, a line in the window; empty: nothing.
    std::span<const glm::dvec2> line() const { return line_; }

private:
    BrushTool tool_ = BrushTool::touch, last_ = BrushTool::paint;
    std::string material_ = "wood";
    bool is_drawing_ = false;
    std::vector<PixelOfFrame> places_;  // of a stroke, or the first of two segments
    std::vector<glm::dvec2> line_;      // the same in the window, and to the pointer
};

}  // namespace touchable
