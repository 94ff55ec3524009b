#include "player/panel/playback_bar.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "player/panel/corner_panels.hpp"
#include "player/panel/panel_rows.hpp"

namespace touchable {
namespace {

std::string clock_words(double seconds) {
    const auto tenths = static_cast<long>(std::floor(std::max(seconds, 0.0) * 10 + 0.5));
    char words[32];
    std::snprintf(words, sizeof words, "%ld:%02ld.%ld", tenths / 600, tenths / 10 % 60, tenths % 10);
    return words;
}

/// Play or pause, drawn: no typeface is sure to have the signs.
bool play_button(bool playing, float side) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const bool pressed = ImGui::Button("##play", ImVec2(side, side));
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text);
    const float u = side / 10;
    if (playing) {
        list.AddRectFilled(ImVec2(at.x + 3 * u, at.y + 2.7F * u), ImVec2(at.x + 4.4F * u, at.y + 7.3F * u),
                           ink);
        list.AddRectFilled(ImVec2(at.x + 5.6F * u, at.y + 2.7F * u), ImVec2(at.x + 7 * u, at.y + 7.3F * u),
                           ink);
    } else {
        list.AddTriangleFilled(ImVec2(at.x + 3.5F * u, at.y + 2.5F * u),
                               ImVec2(at.x + 7.5F * u, at.y + 5 * u),
                               ImVec2(at.x + 3.5F * u, at.y + 7.5F * u), ink);
    }
    return pressed;
}

}  // namespace

/// The bar of time, with a mark where the picture's depth changes all at once.
void PlaybackBar::draw_seek(const PanelFacts& facts, float scale, float room,
                            std::vector<WindowCommand>& asked) {
    const float wide = std::max(60 * scale, room);
    ImGui::SetNextItemWidth(wide);
    const ImVec2 at_left = ImGui::GetCursorScreenPos();
    float at = dragging_ ? dragged_seconds_ : static_cast<float>(facts.seconds);
    const auto end = static_cast<float>(std::max(facts.clip_seconds, 0.001));
    if (ImGui::SliderFloat("##seek", &at, 0, end, "", ImGuiSliderFlags_NoInput)) {
        dragged_seconds_ = at;
        asked.push_back({WindowVerb::seek_to, static_cast<double>(std::clamp(at, 0.0F, end))});
    }
    dragging_ = ImGui::IsItemActive();
    const float grab = ImGui::GetStyle().GrabMinSize / 2 + 2, tall = ImGui::GetItemRectSize().y;
    for (const double cut : facts.cuts) {
        if (cut > end) continue;  // of what has no end
        const float x = at_left.x + grab + (wide - 2 * grab) * static_cast<float>(cut) / end;
        ImGui::GetWindowDrawList()->AddLine(ImVec2(x, at_left.y + tall * 0.68F), ImVec2(x, at_left.y + tall),
                                            IM_COL32(255, 200, 110, 230), 2 * scale);
    }
}

void PlaybackBar::draw(const PanelFacts& facts, float width, float height, float scale,
                       std::vector<WindowCommand>& asked) {
    const float m = panel_margin * scale, side = 30 * scale;
    begin_box(
        "playback",
        {.x = m, .y = height - m, .pivot_y = 1, .width = width - 2 * m, .height = panel_bar_height * scale});
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(8 * scale, (side - ImGui::GetFontSize()) / 2));
    if (play_button(facts.playing && !facts.at_end, side)) asked.push_back({WindowVerb::play_pause});
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    const std::string frame = " frame " + std::to_string(facts.frame);
    const std::string end = facts.clip_seconds > 0 ? " / " + clock_words(facts.clip_seconds) : std::string();
    ImGui::TextUnformatted(
        (clock_words(facts.seconds) + (facts.playing && !facts.at_end ? end : frame)).c_str());
    ImGui::SameLine();
    char speed[32];
    std::snprintf(speed, sizeof speed, "%g\xC3\x97##speed", facts.speed);
    const bool roomy = is_roomy(width, scale);
    const float right = (roomy ? 286 : 96) * scale;
    draw_seek(facts, scale, ImGui::GetContentRegionAvail().x - right, asked);
    ImGui::SameLine();
    if (ImGui::Button(speed, ImVec2(46 * scale, 0)))
        asked.push_back({WindowVerb::speed, facts.speed >= 4 ? 0.25 : facts.speed * 2});
    ImGui::SameLine();
    if (roomy) {
        ImGui::PushStyleColor(ImGuiCol_Text,
                              ImGui::GetStyle().Colors[facts.looping ? ImGuiCol_SliderGrab : ImGuiCol_Text]);
        if (ImGui::Button("loop")) asked.push_back({WindowVerb::loop});
        ImGui::PopStyleColor();
        ImGui::SameLine();
        if (ImGui::Button((facts.overlay + "##overlay").c_str(), ImVec2(132 * scale, 0)))
            asked.push_back({WindowVerb::overlay});
        ImGui::SameLine();
    }
    if (ImGui::Button("?", ImVec2(side, 0))) asked.push_back({WindowVerb::help});
    ImGui::PopStyleVar();
}

}  // namespace touchable
