#include "player/window/brush_tool.hpp"

#include <utility>

namespace touchable {
namespace {

constexpr BrushTool all_tools[] = {BrushTool::touch, BrushTool::paint, BrushTool::join, BrushTool::cut};

}  // namespace

const char* name_of(BrushTool tool) {
    switch (tool) {
        case BrushTool::paint:
            return "paint";
        case BrushTool::join:
            return "join";
        case BrushTool::cut:
            return "cut";
        case BrushTool::touch:
            break;
    }
    return "touch";
}

std::span<const BrushTool> brush_tools() {
    return all_tools;
}

std::optional<BrushTool> brush_tool_of(std::string_view name) {
    for (const BrushTool tool : all_tools)
        if (name == name_of(tool)) return tool;
    return std::nullopt;
}

void HeldBrush::take(BrushTool tool) {
    let_go();
    tool_ = tool;
    if (tool != BrushTool::touch) last_ = tool;
}

void HeldBrush::let_go() {
    is_drawing_ = false;
    places_.clear();
    line_.clear();
}

std::optional<WindowCommand> HeldBrush::press(const Place& place) {
    if (tool_ == BrushTool::cut) {
        let_go();
        is_drawing_ = true;
        move(place);
        return std::nullopt;
    }
    if (!place.pixel) {
        let_go();
        return std::nullopt;
    }
    if (tool_ == BrushTool::paint) return WindowCommand{.verb = WindowVerb::paint, .places = {*place.pixel}};
    if (tool_ != BrushTool::join) return std::nullopt;
    if (!places_.empty()) {
        WindowCommand join{.verb = WindowVerb::join, .places = {places_[0], *place.pixel}};
        let_go();
        return join;
    }
    line_ = {place.at, place.at};
    places_ = {*place.pixel};
    return std::nullopt;
}

void HeldBrush::move(const Place& place) {
    if (tool_ == BrushTool::join && !line_.empty()) line_.back() = place.at;
    if (!is_drawing_ || !place.pixel || places_.size() == most_points) return;
    PixelOfFrame pixel = *place.pixel;
    if (!places_.empty()) pixel.frame = places_[0].frame;  // while it is drawn the clip waits
    if (!places_.empty() && pixel == places_.back()) return;
    places_.push_back(pixel);
    line_.push_back(place.at);
}

std::optional<WindowCommand> HeldBrush::release() {
    if (!is_drawing_) return std::nullopt;
    WindowCommand cut{.verb = WindowVerb::cut, .places = std::move(places_)};
    let_go();
    return cut.places.size() > 1 ? std::optional(std::move(cut)) : std::nullopt;
}

}  // namespace touchable
