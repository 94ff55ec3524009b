#include "player/window/measure_panel.hpp"

#include <imgui.h>

#include <algorithm>

#include "player/window/panel_rows.hpp"

namespace touchable {
namespace {

constexpr ImU32 dark_ink = IM_COL32(0, 0, 0, 200), light_ink = IM_COL32(255, 255, 255, 255),
                frozen_ink = IM_COL32(255, 200, 110, 255);

void draw_end(ImDrawList& list, const ImVec2& at, ImU32 ink, float scale) {
    list.AddCircle(at, 6 * scale, dark_ink, 0, 4 * scale);
    list.AddCircle(at, 6 * scale, ink, 0, 2 * scale);
    list.AddCircleFilled(at, 1.6F * scale, ink);
}

/// Above the line's middle, and within the picture.
void draw_length(ImDrawList& list, const ImVec2& middle, const std::string& words, ImU32 ink, float scale) {
    const ImVec2 text = ImGui::CalcTextSize(words.c_str()), display = ImGui::GetIO().DisplaySize;
    const float x = 6 * scale, y = 3 * scale, wide = text.x + 2 * x, tall = text.y + 2 * y;
    const ImVec2 at(std::clamp(middle.x - wide / 2, 0.0F, std::max(display.x - wide, 0.0F)),
                    std::clamp(middle.y - tall - 10 * scale, 0.0F, std::max(display.y - tall, 0.0F)));
    list.AddRectFilled(at, ImVec2(at.x + wide, at.y + tall), IM_COL32(14, 17, 22, 215), 5 * scale);
    list.AddText(ImVec2(at.x + x, at.y + y), ink, words.c_str());
}

}  // namespace

void draw_measure(const MeasureFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    draw_label("measure", scale);
    const int clicked = draw_words("measure", {"off", "on"}, facts.is_held ? 1 : 0, true);
    if (clicked == 0) asked.push_back({.verb = WindowVerb::measure, .word = "off"});
    if (clicked == 1 && !facts.is_held) asked.push_back({.verb = WindowVerb::measure});
    explain_row(
        "How far two places of the surface are apart in the scene: click both, or drag from one to the "
        "other. "
        "T does the same, and leaves the line when it puts the tool away; off takes it away.");
}

void draw_measured_line(const MeasureFacts& facts, float scale) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const ImU32 ink = facts.is_frozen ? frozen_ink : light_ink;
    const auto point = [](const glm::dvec2& at) {
        return ImVec2(static_cast<float>(at.x), static_cast<float>(at.y));
    };
    if (facts.next) draw_end(list, point(*facts.next), light_ink, scale);
    if (facts.ends.size() == 1) draw_end(list, point(facts.ends[0]), ink, scale);
    if (facts.ends.size() != 2) return;
    const ImVec2 from = point(facts.ends[0]), to = point(facts.ends[1]);
    list.AddLine(from, to, dark_ink, 5 * scale);
    list.AddLine(from, to, ink, 2 * scale);
    draw_end(list, from, ink, scale);
    draw_end(list, to, ink, scale);
    draw_length(list, ImVec2((from.x + to.x) / 2, (from.y + to.y) / 2), facts.words, ink, scale);
}

}  // namespace touchable
