#include "player/window/empty_page.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>

namespace touchable {
namespace {

constexpr const char* page_title = "Drop a depth video here";
constexpr const char* other_things =
    "or several; a folder of pictures; a photo with depth; a recording of a camera";
/// Who has none, and what helps.
constexpr struct {
    const char *wish, *command;
} ways[] = {{"make one", "touchable make globe globe.mkv"},
            {"what can be opened", "touchable formats"},
            {"a depth camera that is plugged in", "touchable cameras"},
            {"close", "Q, or Escape"}};

}  // namespace

const char* empty_page_title() {
    return page_title;
}

void draw_empty_page(float width, float height, float scale) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    ImFont* const large = ImGui::GetIO().Fonts->Fonts.back();
    ImFont* const font = ImGui::GetFont();
    const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text), dim = ImGui::GetColorU32(ImGuiCol_TextDisabled),
                accent = ImGui::GetColorU32(ImGuiCol_SliderGrab);
    const float size = ImGui::GetFontSize(), line = 1.6F * size, gap = 1.5F * size;
    const auto wide = [&](ImFont* of, float at, float wrap, const char* words) {
        return of->CalcTextSizeA(at, 1e6F, wrap, words);
    };
    const float room = 0.9F * width, plain = wide(large, 1, 0, page_title).x;
    const float title_size = std::clamp(room / plain, size, 48 * scale);
    float wish = 0, command = 0;
    for (const auto& way : ways) {
        wish = std::max(wish, wide(font, size, 0, way.wish).x);
        command = std::max(command, wide(font, size, 0, way.command).x);
    }
    const ImVec2 whole = wide(font, size, room, other_things);
    const float tall = 1.5F * title_size + whole.y + gap + line * static_cast<float>(std::size(ways));
    float y = std::max((height - tall) / 2, size);
    list.AddText(large, title_size, ImVec2((width - plain * title_size) / 2, y), ink, page_title);
    y += 1.5F * title_size;
    list.AddText(font, size, ImVec2((width - whole.x) / 2, y), dim, other_things, nullptr, room);
    y += whole.y + gap;
    const float left = std::max((width - wish - gap - command) / 2, size / 2);
    for (const auto& way : ways) {
        list.AddText(font, size, ImVec2(left, y), dim, way.wish);
        list.AddText(font, size, ImVec2(left + wish + gap, y), accent, way.command);
        y += line;
    }
}

}  // namespace touchable
