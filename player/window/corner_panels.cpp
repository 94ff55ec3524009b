#include "player/window/corner_panels.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "engine/base/number_words.hpp"
#include "player/draw/colour_ramp.hpp"
#include "player/window/panel_rows.hpp"

namespace touchable {
namespace {

constexpr ImGuiWindowFlags fixed_window = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                          ImGuiWindowFlags_NoSavedSettings |
                                          ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

/// `beyond`: what lies there has the same colour.
std::string end_of_scale(double value, const char* beyond) {
    return beyond + formatted("%.4g", value);
}

}  // namespace

void begin_box(const char* name, const FixedBox& box) {
    ImGui::SetNextWindowPos(ImVec2(box.x, box.y), ImGuiCond_Always, ImVec2(box.pivot_x, box.pivot_y));
    const bool has_size = box.width > 0 || box.height > 0, fits = box.width > 0 && box.height > 0;
    if (has_size) ImGui::SetNextWindowSize(ImVec2(box.width, box.height), ImGuiCond_Always);
    const int fixed = box.scrolls ? fixed_window & ~ImGuiWindowFlags_NoScrollbar : fixed_window;
    ImGui::Begin(name, nullptr, fixed | box.flags | (fits ? 0 : ImGuiWindowFlags_AlwaysAutoResize));
}

namespace {

/// From one line across the force bar to the next: a round number of newtons, three to seven of them.
double newtons_of_line(double limit) {
    const double decade = std::pow(10.0, std::floor(std::log10(limit)));
    const double lead = limit / decade;
    return decade * (lead < 1.5 ? 0.25 : (lead < 3 ? 0.5 : (lead < 6 ? 1 : 2)));
}

}  // namespace

void draw_force(const PanelFacts& facts, float height, float scale) {
    constexpr double beyond_limit = 1.08;  // so that the mark of the limit has bar on either side
    const float m = panel_margin * scale;
    const auto fingers = static_cast<float>(std::max<std::size_t>(facts.forces.size(), 1));
    const float each = std::min(18 * scale, 180 * scale / fingers);
    const float bar = each * 2 / 3, gap = each / 3, tall = std::min(150 * scale, height * 0.3F);
    // What is in a box tells its size a picture later: where that is known before, it is said.
    const ImGuiStyle& style = ImGui::GetStyle();
    const std::string limit_words =
        (facts.kiosk ? facts.kiosk->texts.limit : "limit") + formatted(" %.3g N", facts.limit_newtons);
    const float wide = std::max(ImGui::CalcTextSize(limit_words.c_str()).x, fingers * (bar + gap) - gap);
    begin_box("force",
              {.x = m,
               .y = m,
               .width = wide + 2 * style.WindowPadding.x,
               .height = tall + 2 * ImGui::GetTextLineHeightWithSpacing() + 2 * style.WindowPadding.y,
               .flags = ImGuiWindowFlags_NoInputs});
    double most = 0;
    for (const double force : facts.forces) most = std::max(most, force);
    if (facts.force_on || facts.kiosk)  // which says it large, in its own words
        ImGui::TextUnformatted(formatted("%.1f N", most).c_str());
    else
        ImGui::TextColored(ImVec4(0.95F, 0.65F, 0.35F, 1), "force off");
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const auto level = [&](double newtons) {
        const double share = std::clamp(newtons / (beyond_limit * facts.limit_newtons), 0.0, 1.0);
        return at.y + tall * (1 - static_cast<float>(share));
    };
    const float right = at.x + std::max(fingers * (bar + gap) - gap, 3 * bar);
    for (std::size_t k = 0; k < facts.forces.size(); ++k) {
        const float x = at.x + static_cast<float>(k) * (bar + gap), top = level(facts.forces[k]);
        list.AddRectFilled(ImVec2(x, at.y), ImVec2(x + bar, at.y + tall), IM_COL32(255, 255, 255, 28),
                           bar / 3);
        if (at.y + tall - top > 0.5F)
            list.AddRectFilled(ImVec2(x, top), ImVec2(x + bar, at.y + tall), readable_finger_colour(k),
                               bar / 3);
    }
    const double line = newtons_of_line(facts.limit_newtons);
    for (double newtons = line; newtons < 0.999 * facts.limit_newtons; newtons += line)
        list.AddLine(ImVec2(at.x, level(newtons)), ImVec2(right, level(newtons)), IM_COL32(255, 255, 255, 70),
                     scale);
    const float limit = level(facts.limit_newtons);
    list.AddLine(ImVec2(at.x - 2 * scale, limit), ImVec2(right + 2 * scale, limit),
                 IM_COL32(255, 160, 90, 255), 2 * scale);
    ImGui::Dummy(ImVec2(wide, tall));
    ImGui::TextColored(ImVec4(1, 0.63F, 0.35F, 1), "%s", limit_words.c_str());
    ImGui::End();
}

float draw_place(const PanelFacts& facts, float width, float height, float scale) {
    std::span<const std::string> words = facts.place.lines;
    const float m = panel_margin * scale, bottom = height - 2 * m - panel_bar_height * scale;
    // What lies behind the bar, or the panel, nobody looks at; and a button's explanation has the room.
    if (words.empty() || ImGui::IsWindowHovered(ImGuiHoveredFlags_AnyWindow)) return bottom;
    // As large as there is room for, but legible; lines that then do not fit are left out.
    constexpr float smallest = 12.0F / 15;
    const ImVec2 padding = ImGui::GetStyle().WindowPadding;
    const float font = ImGui::GetFontSize(), gap = 2 * scale, room = height / 5 - 2 * padding.y;
    const float wide_room = width / 2 - 2 * padding.x;
    const auto tall = [&](float share) {
        return static_cast<float>(words.size()) * (share * font + gap) - gap;
    };
    while (words.size() > 1 && tall(smallest) > room) words = words.first(words.size() - 1);
    const auto wide = [](const std::string& line) { return ImGui::CalcTextSize(line.c_str()).x; };
    const auto is_wide = [&](const std::string& line) { return smallest * wide(line) > wide_room; };
    const auto fitting = std::find_if(words.begin() + 1, words.end(), is_wide) - words.begin();
    words = words.first(static_cast<std::size_t>(fitting));
    float widest = 0;
    for (const std::string& line : words) widest = std::max(widest, wide(line));
    const float share =
        std::clamp(std::min((room - tall(0)) / (tall(1) - tall(0)), wide_room / widest), smallest, 1.0F);
    const float whole = tall(share) + 2 * padding.y;
    begin_box("place", {.x = m,
                        .y = bottom,
                        .pivot_y = 1,
                        .width = share * widest + 2 * padding.x,
                        .height = whole,
                        .flags = ImGuiWindowFlags_NoInputs});
    ImGui::SetWindowFontScale(share);
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(gap, gap));
    for (const std::string& line : words) ImGui::TextUnformatted(line.c_str());
    ImGui::PopStyleVar();
    ImGui::End();
    return bottom - whole - m;
}

namespace {

/// A colour and what it means.
void draw_class(PackedColour colour, const char* words, float scale) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float side = ImGui::GetFontSize();
    ImGui::GetWindowDrawList()->AddRectFilled(at, ImVec2(at.x + side, at.y + side), colour, 3 * scale);
    ImGui::Dummy(ImVec2(side, side));
    ImGui::SameLine();
    ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + 290 * scale);
    ImGui::TextUnformatted(words);
    ImGui::PopTextWrapPos();
}

/// The ramp, and below it its ends; the middle too where values do not lie evenly.
void draw_ramp(const OverlayScale& scale_of, float scale) {
    const float wide = 220 * scale, tall = 12 * scale;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    constexpr int steps = 50;
    for (int k = 0; k < steps; ++k) {
        const double share = (k + 0.5) / steps;
        list.AddRectFilled(ImVec2(at.x + wide * static_cast<float>(k) / steps, at.y),
                           ImVec2(at.x + wide * static_cast<float>(k + 1) / steps, at.y + tall),
                           ramp_colour(scale_of.least_is_light ? 1 - share : share));
    }
    ImGui::Dummy(ImVec2(wide, tall));
    // `part`: of the words that is left of the place.
    const auto draw_at = [&](float place, const std::string& words, float part) {
        ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + place -
                        part * ImGui::CalcTextSize(words.c_str()).x);
        ImGui::TextDisabled("%s", words.c_str());
    };
    ImGui::TextDisabled("%s", end_of_scale(scale_of.range.least, scale_of.is_less ? "< " : "").c_str());
    if (!scale_of.levels.empty())
        draw_at(wide / 2, formatted("%.3g", scale_of.levels[scale_of.levels.size() / 2]), 0.5F);
    draw_at(wide, end_of_scale(scale_of.range.greatest, scale_of.is_more ? "> " : ""), 1);
}

}  // namespace

void draw_overlay_scale(const OverlayScale& scale_of, float right, float bottom, float scale) {
    begin_box("scale",
              {.x = right, .y = bottom, .pivot_x = 1, .pivot_y = 1, .flags = ImGuiWindowFlags_NoInputs});
    const std::string everywhere = scale_of.everywhere();
    ImGui::TextUnformatted((everywhere.empty() ? scale_of.title() : scale_of.name).c_str());
    for (const OverlayScale::Class& named : scale_of.classes)
        draw_class(named.colour, named.words.c_str(), scale);
    if (!everywhere.empty()) draw_class(ramp_colour(0.5), everywhere.c_str(), scale);
    if (scale_of.classes.empty() && everywhere.empty()) draw_ramp(scale_of, scale);
    ImGui::End();
}

}  // namespace touchable
