#include "player/window/panel_rows.hpp"

#include <imgui.h>

#include <algorithm>

namespace touchable {
namespace {

constexpr float label_width = 98, value_width = 72;

}  // namespace

void draw_heading(const char* words) {
    ImGui::Spacing();
    ImGui::TextColored(ImGui::GetStyle().Colors[ImGuiCol_SliderGrab], "%s", words);
}

void draw_remark(const std::string& words) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyle().Colors[ImGuiCol_TextDisabled]);
    ImGui::TextWrapped("%s", words.c_str());
    ImGui::PopStyleColor();
}

void draw_label(const std::string& words, float scale) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(words.c_str());
    ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + label_width * scale);
}

bool draw_slider(const char* id, float& value, float least, float most, const std::string& words, float scale,
                 int flags) {
    const ImGuiStyle& style = ImGui::GetStyle();
    const float wide = std::max(ImGui::GetContentRegionAvail().x - value_width * scale, 40 * scale);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::SetNextItemWidth(wide);
    const bool moved = ImGui::SliderFloat(id, &value, least, most, "",
                                          flags | ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput);
    ImGui::GetWindowDrawList()->AddText(
        ImVec2(at.x + wide + style.ItemInnerSpacing.x * 1.5F, at.y + style.FramePadding.y),
        ImGui::GetColorU32(ImGuiCol_Text), words.c_str());
    return moved;
}

int draw_words(const char* id, const std::vector<const char*>& words, int chosen, bool by_hand) {
    int clicked = -1;
    const auto count = static_cast<float>(words.size());
    const ImGuiStyle& style = ImGui::GetStyle();
    const float gap = style.ItemInnerSpacing.x / 2;
    const float wide = (ImGui::GetContentRegionAvail().x - gap * (count - 1)) / count;
    const ImVec4 lit = style.Colors[by_hand ? ImGuiCol_SliderGrab : ImGuiCol_ButtonActive];
    const ImVec4 ground = style.Colors[ImGuiCol_WindowBg];
    const ImVec4 ink = by_hand ? ImVec4(ground.x, ground.y, ground.z, 1) : style.Colors[ImGuiCol_Text];
    ImGui::PushID(id);
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(0, style.FramePadding.y));
    for (int k = 0; k < static_cast<int>(words.size()); ++k) {
        if (k > 0) ImGui::SameLine(0, gap);
        const bool is_chosen = k == chosen;
        ImGui::PushStyleColor(ImGuiCol_Text, is_chosen ? ink : style.Colors[ImGuiCol_TextDisabled]);
        if (is_chosen)
            for (const int part : {ImGuiCol_Button, ImGuiCol_ButtonHovered}) ImGui::PushStyleColor(part, lit);
        if (ImGui::Button(words[static_cast<std::size_t>(k)], ImVec2(wide, 0))) clicked = k;
        ImGui::PopStyleColor(is_chosen ? 3 : 1);
    }
    ImGui::PopStyleVar();
    ImGui::PopID();
    return clicked;
}

}  // namespace touchable
