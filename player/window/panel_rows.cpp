#include "player/window/panel_rows.hpp"

#include <algorithm>

#include "player/draw/finger_marks.hpp"

namespace touchable {
namespace {

constexpr float label_width = 98, value_width = 72;

}  // namespace

bool draw_fold(const char* words, bool out) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyle().Colors[ImGuiCol_SliderGrab]);
    const bool is_out = ImGui::CollapsingHeader(words, out ? ImGuiTreeNodeFlags_DefaultOpen : 0);
    ImGui::PopStyleColor();
    return is_out;
}

float value_column(float scale) {
    return std::max(ImGui::GetContentRegionAvail().x - value_width * scale, 40 * scale);
}

void draw_value(const char* words, float right_of, float top) {
    ImGui::GetWindowDrawList()->AddText(ImVec2(right_of + ImGui::GetStyle().ItemInnerSpacing.x * 1.5F, top),
                                        ImGui::GetColorU32(ImGuiCol_Text), words);
}

void explain_row(const char* words) {
    const ImVec2 panel = ImGui::GetWindowPos();
    const ImVec2 least(panel.x, ImGui::GetItemRectMin().y),
        most(panel.x + ImGui::GetWindowWidth(), ImGui::GetItemRectMax().y);
    if (!words || !*words || !ImGui::IsWindowHovered(ImGuiHoveredFlags_AllowWhenBlockedByActiveItem) ||
        !ImGui::IsMouseHoveringRect(least, most, false))
        return;
    const float gap = ImGui::GetStyle().ItemSpacing.x, room = panel.x - 2 * gap;
    ImGui::SetNextWindowPos(ImVec2(panel.x - gap, least.y - gap), ImGuiCond_Always, ImVec2(1, 0));
    ImGui::SetNextWindowBgAlpha(0.95F);
    ImGui::Begin("explanation", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                     ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::PushTextWrapPos(std::min(18 * ImGui::GetFontSize(), room - 2 * gap));
    ImGui::TextUnformatted(words);
    ImGui::PopTextWrapPos();
    ImGui::End();
}

float explanation_height() {
    return ImGui::GetTextLineHeight() + ImGui::GetStyle().WindowPadding.y;
}

/// In front of whatever is there.
bool explain_button(const char* words) {
    if (!ImGui::IsItemHovered()) return false;
    const ImGuiStyle& style = ImGui::GetStyle();
    const ImVec2 text = ImGui::CalcTextSize(words), pad(style.WindowPadding.x, style.WindowPadding.y / 2),
                 least = ImGui::GetItemRectMin(), most = ImGui::GetItemRectMax();
    const float gap = style.ItemSpacing.x, wide = text.x + 2 * pad.x, tall = explanation_height(),
                room = ImGui::GetIO().DisplaySize.x - gap - wide;
    const ImVec2 at(std::clamp((least.x + most.x - wide) / 2, gap, std::max(room, gap)),
                    ImGui::GetWindowPos().y - gap - tall);
    ImDrawList& list = *ImGui::GetForegroundDrawList();
    const ImVec2 end(at.x + wide, at.y + tall);
    list.AddRectFilled(at, end, IM_COL32(14, 17, 22, 255), style.WindowRounding);
    list.AddRect(at, end, ImGui::GetColorU32(ImGuiCol_Border), style.WindowRounding);
    list.AddText(ImVec2(at.x + pad.x, at.y + pad.y), ImGui::GetColorU32(ImGuiCol_Text), words);
    return true;
}

ImFont* font_of_size(float size) {
    ImFont* const small = ImGui::GetFont();
    return size <= 1.15F * small->FontSize ? small : ImGui::GetIO().Fonts->Fonts.back();
}

ImU32 readable_finger_colour(std::size_t finger) {
    const ImVec4 c = ImGui::ColorConvertU32ToFloat4(finger_colour(finger) | 0xFF000000U);
    const float grey = 0.3F * c.x + 0.6F * c.y + 0.1F * c.z, lift = std::clamp(0.62F - grey, 0.0F, 0.45F);
    return ImGui::ColorConvertFloat4ToU32(
        ImVec4(c.x + (1 - c.x) * lift, c.y + (1 - c.y) * lift, c.z + (1 - c.z) * lift, 1));
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
    const float wide = value_column(scale);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::SetNextItemWidth(wide);
    const bool moved = ImGui::SliderFloat(id, &value, least, most, "",
                                          flags | ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput);
    draw_value(words.c_str(), at.x + wide, at.y + ImGui::GetStyle().FramePadding.y);
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
