#include "player/window/materials_panel.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "engine/authoring/palette.hpp"
#include "player/window/material_colours.hpp"
#include "player/window/panel_rows.hpp"

namespace touchable {
namespace {

ImU32 chip_colour(std::string_view material) {
    const auto rgb = material_colour(material);
    return IM_COL32(rgb[0], rgb[1], rgb[2], 255);
}

/// A chip of the colour and the name. Whether it was clicked.
bool draw_material(const PaletteMaterial& material, bool is_in_hand, float wide, float scale) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float tall = ImGui::GetFrameHeight(), chip = tall - 8 * scale;
    const std::string id = "##" + std::string(material.name);
    ImGui::PushStyleColor(ImGuiCol_Button,
                          ImGui::GetStyle().Colors[is_in_hand ? ImGuiCol_ButtonActive : ImGuiCol_FrameBg]);
    const bool clicked = ImGui::Button(id.c_str(), ImVec2(wide, 0));
    ImGui::PopStyleColor();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImVec2 least(at.x + 4 * scale, at.y + 4 * scale), most(least.x + chip, least.y + chip);
    list.AddRectFilled(least, most, chip_colour(material.name), 2 * scale);
    if (is_in_hand)
        list.AddRect(at, ImVec2(at.x + wide, at.y + tall), ImGui::GetColorU32(ImGuiCol_SliderGrab), 3 * scale,
                     0, 1.5F * scale);
    list.AddText(ImVec2(most.x + 5 * scale, at.y + ImGui::GetStyle().FramePadding.y),
                 ImGui::GetColorU32(ImGuiCol_Text), std::string(material.name).c_str());
    return clicked;
}

void draw_palette(const BrushFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x, room = ImGui::GetContentRegionAvail().x,
                longest = ImGui::CalcTextSize("cardboard").x + ImGui::GetFrameHeight() + 2 * scale;
    const int columns = room < 3 * longest + 2 * gap ? 2 : 3;
    const auto count = static_cast<float>(columns);
    const float wide = std::floor((room - gap * (count - 1)) / count);
    int column = 0;
    for (const PaletteMaterial& material : palette()) {
        if (column > 0) ImGui::SameLine(0, gap);
        if (draw_material(material, facts.material == material.name, wide, scale))
            asked.push_back({.verb = WindowVerb::material, .word = std::string(material.name)});
        column = (column + 1) % columns;
    }
}

void draw_button(const char* words, bool may, float wide, WindowVerb verb,
                 std::vector<WindowCommand>& asked) {
    ImGui::BeginDisabled(!may);
    if (ImGui::Button(words, ImVec2(wide, 0))) asked.push_back({.verb = verb});
    ImGui::EndDisabled();
}

}  // namespace

void draw_materials(const BrushFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    draw_label("left button", scale);
    std::vector<const char*> names;
    for (const BrushTool tool : brush_tools()) names.push_back(name_of(tool));
    const auto held = std::ranges::find(brush_tools(), facts.tool) - brush_tools().begin();
    const int tool = draw_words("tool", names, static_cast<int>(held), true);
    if (tool >= 0) asked.push_back({.verb = WindowVerb::tool, .word = names[static_cast<std::size_t>(tool)]});
    explain_row(
        "What the left button does: touches; paints the segment that is clicked; makes one of two that are "
        "clicked; or cuts one by a stroke that is dragged over it.");
    draw_palette(facts, scale, asked);
    if (facts.is_there) {
        draw_label("all others", scale);
        // What they are, if that is one material, or what they can be.
        const std::string& one = facts.otherwise.empty() ? facts.material : facts.otherwise;
        const int others =
            draw_words("others", {"guessed", one.c_str()}, facts.otherwise.empty() ? 0 : 1, true);
        if (others >= 0)
            asked.push_back({.verb = WindowVerb::otherwise, .word = others == 0 ? "" : facts.material});
        explain_row("What nobody painted: a guess for each segment, or the material in hand for all.");
        draw_label("felt", scale);
        const int felt = draw_words("felt", {"before", "as painted"}, facts.materials_are_on ? 1 : 0, true);
        if (felt >= 0)
            asked.push_back({.verb = WindowVerb::feel, .word = felt == 1 ? "materials on" : "materials off"});
        explain_row("As the clip is by itself, or as it is painted. The key B changes between both.");
    }
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x,
                wide = std::floor((ImGui::GetContentRegionAvail().x - 2 * gap) / 3);
    draw_button("undo", facts.can_undo, wide, WindowVerb::undo, asked);
    ImGui::SameLine(0, gap);
    draw_button("redo", facts.can_redo, wide, WindowVerb::redo, asked);
    ImGui::SameLine(0, gap);
    draw_button("save", facts.is_there, wide, WindowVerb::save_materials, asked);
    if (facts.is_there) draw_remark(std::to_string(facts.segments) + " segments in the clip");
}

void draw_brush_line(const BrushFacts& facts, float scale) {
    if (facts.line.empty()) return;
    std::vector<ImVec2> points;
    for (const glm::dvec2& at : facts.line)
        points.emplace_back(static_cast<float>(at.x), static_cast<float>(at.y));
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto count = static_cast<int>(points.size());
    list.AddPolyline(points.data(), count, IM_COL32(0, 0, 0, 200), 0, 5 * scale);
    list.AddPolyline(points.data(), count, IM_COL32(255, 255, 255, 255), 0, 2 * scale);
    list.AddCircleFilled(points.front(), 5 * scale, IM_COL32(0, 0, 0, 200));
    list.AddCircleFilled(points.front(), 3 * scale, IM_COL32(255, 255, 255, 255));
}

}  // namespace touchable
