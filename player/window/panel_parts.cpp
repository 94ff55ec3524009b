// SPDX-License-Identifier: Apache-2.0
#include "player/window/panel_parts.hpp"

#include <numbers>

namespace touchable {
namespace {

constexpr float label_width = 98, value_width = 72;

constexpr ImGuiWindowFlags fixed_window = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                          ImGuiWindowFlags_NoSavedSettings |
                                          ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

constexpr float half_turn = std::numbers::pi_v<float>;

/// Draws in tenths of a square.
struct Sketch {
    ImDrawList& list;
    ImVec2 at;
    float side;
    ImU32 ink;

    ImVec2 point(float x, float y) const { return {at.x + x * side / 10, at.y + y * side / 10}; }
    void box(float x0, float y0, float x1, float y1) const {
        list.AddRectFilled(point(x0, y0), point(x1, y1), ink);
    }
    void triangle(const ImVec2& a, const ImVec2& b, const ImVec2& c) const {
        list.AddTriangleFilled(a, b, c, ink);
    }
    void disc(float x, float y, float radius, ImU32 colour) const {
        list.AddCircleFilled(point(x, y), radius * side / 10, colour, 32);
    }
    void arc(float x, float y, float radius, float from, float to) const {
        list.PathArcTo(point(x, y), radius * side / 10, from, to, 32);
        list.PathStroke(ink, 0, 0.09F * side);
    }
};

/// A fingertip with an arc round it.
void draw_touch(const Sketch& sketch) {
    sketch.disc(5, 4.4F, 0.8F, sketch.ink);
    sketch.box(4.2F, 4.4F, 5.8F, 8.2F);
    sketch.arc(5, 4.4F, 2.3F, -1.17F * half_turn, 0.17F * half_turn);
}

/// A nearly closed circular arrow.
void draw_turn(const Sketch& sketch) {
    constexpr float radius = 2.4F, from = -0.2F * half_turn, to = 1.4F * half_turn, head = 1.2F;
    sketch.arc(5, 5, radius, from, to);
    const auto on = [&](float r, float angle) {
        return sketch.point(5 + r * std::cos(angle), 5 + r * std::sin(angle));
    };
    sketch.triangle(on(radius - head, to), on(radius + head, to), on(radius + 0.25F, to + 0.3F * half_turn));
}

/// Samples of the ramp.
void draw_colours(const Sketch& sketch) {
    sketch.disc(5, 3.6F, 1.7F, ramp_colour(0.95));
    sketch.disc(3.6F, 6.2F, 1.7F, ramp_colour(0.25));
    sketch.disc(6.4F, 6.2F, 1.7F, ramp_colour(0.6));
}

}  // namespace

bool draw_fold(const char* words, bool out) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyle().Colors[ImGuiCol_SliderGrab]);
    const bool is_out = ImGui::CollapsingHeader(words, out ? ImGuiTreeNodeFlags_DefaultOpen : 0);
    ImGui::PopStyleColor();
    return is_out;
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
    ImGui::SetNextWindowBgAlpha(0.95F);
    begin_box("explanation",
              {.x = panel.x - gap, .y = least.y - gap, .pivot_x = 1, .flags = ImGuiWindowFlags_NoInputs});
    ImGui::PushTextWrapPos(std::min(18 * ImGui::GetFontSize(), room - 2 * gap));
    ImGui::TextUnformatted(words);
    ImGui::PopTextWrapPos();
    ImGui::End();
}

/// Draws in front of all panels.
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

float explanation_height() {
    return ImGui::GetTextLineHeight() + ImGui::GetStyle().WindowPadding.y;
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

void draw_sign(ButtonSign sign, const ImVec2& at, float side, ImU32 ink) {
    const Sketch sketch{*ImGui::GetWindowDrawList(), at, side, ink};
    const auto point = [&](float x, float y) { return sketch.point(x, y); };
    switch (sign) {
        case ButtonSign::pause:
            sketch.box(3, 2.7F, 4.4F, 7.3F);
            return sketch.box(5.6F, 2.7F, 7, 7.3F);
        case ButtonSign::play:
            return sketch.triangle(point(3.5F, 2.5F), point(7.5F, 5), point(3.5F, 7.5F));
        case ButtonSign::next:
            sketch.triangle(point(2.7F, 2.7F), point(6, 5), point(2.7F, 7.3F));
            return sketch.box(6.2F, 2.7F, 7.4F, 7.3F);
        case ButtonSign::previous:
            sketch.triangle(point(7.3F, 2.7F), point(4, 5), point(7.3F, 7.3F));
            return sketch.box(2.6F, 2.7F, 3.8F, 7.3F);
        case ButtonSign::home:
            sketch.triangle(point(2.4F, 5.1F), point(5, 2.5F), point(7.6F, 5.1F));
            return sketch.box(3.3F, 5, 6.7F, 7.5F);
        case ButtonSign::touch:
            return draw_touch(sketch);
        case ButtonSign::turn:
            return draw_turn(sketch);
        case ButtonSign::colours:
            return draw_colours(sketch);
        case ButtonSign::none:
            return;
    }
}

void begin_box(const char* name, const FixedBox& box) {
    ImGui::SetNextWindowPos(ImVec2(box.x, box.y), ImGuiCond_Always, ImVec2(box.pivot_x, box.pivot_y));
    const bool has_size = box.width > 0 || box.height > 0, fits = box.width > 0 && box.height > 0;
    if (has_size) ImGui::SetNextWindowSize(ImVec2(box.width, box.height), ImGuiCond_Always);
    int fixed = box.scrolls ? fixed_window & ~ImGuiWindowFlags_NoScrollbar : fixed_window;
    if (box.has_keys) fixed &= ~ImGuiWindowFlags_NoNav;
    if (box.has_keys && !ImGui::IsAnyItemActive()) ImGui::SetNextWindowFocus();
    ImGui::Begin(name, nullptr, fixed | box.flags | (fits ? 0 : ImGuiWindowFlags_AlwaysAutoResize));
}

}  // namespace touchable
