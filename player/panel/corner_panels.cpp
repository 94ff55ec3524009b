#include "player/panel/corner_panels.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "player/control/window_command.hpp"
#include "player/overlay/colour_ramp.hpp"
#include "player/panel/panel_rows.hpp"

namespace touchable {
namespace {

constexpr ImGuiWindowFlags fixed_window = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                          ImGuiWindowFlags_NoSavedSettings |
                                          ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

template <class... Values>
std::string short_text(const char* format, Values... values) {
    char words[160];
    std::snprintf(words, sizeof words, format, values...);
    return words;
}

/// `beyond`: what lies there has the same colour.
std::string end_of_scale(double value, const char* beyond) {
    return beyond + short_text("%.4g", value);
}

/// A key's name as keyboards print it.
std::string printed(std::string key) {
    if (key[0] >= 'a' && key[0] <= 'z') key[0] = static_cast<char>(key[0] - 'a' + 'A');
    return key;
}

/// Of keys that lead the pointer's fingers or a device's, whichever is not there.
bool does_nothing(WindowVerb verb, bool is_held) {
    switch (verb) {
        case WindowVerb::fingers:
        case WindowVerb::deeper:
        case WindowVerb::point_right:
        case WindowVerb::point_down:
            return is_held;
        case WindowVerb::clutch:
        case WindowVerb::recentre:
        case WindowVerb::coarser:
            return !is_held;
        default:
            return false;
    }
}

}  // namespace

void begin_box(const char* name, const FixedBox& box) {
    ImGui::SetNextWindowPos(ImVec2(box.x, box.y), ImGuiCond_Always, ImVec2(box.pivot_x, box.pivot_y));
    const bool has_size = box.width > 0 || box.height > 0, fits = box.width > 0 && box.height > 0;
    if (has_size) ImGui::SetNextWindowSize(ImVec2(box.width, box.height), ImGuiCond_Always);
    ImGui::Begin(name, nullptr, fixed_window | box.flags | (fits ? 0 : ImGuiWindowFlags_AlwaysAutoResize));
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
    const std::string limit_words = short_text("limit %.3g N", facts.limit_newtons);
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
        ImGui::TextUnformatted(short_text("%.1f N", most).c_str());
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

void draw_place(const PanelFacts& facts, float height, float scale) {
    if (facts.place.lines.empty()) return;
    const float m = panel_margin * scale;
    const ImGuiStyle& style = ImGui::GetStyle();
    float wide = 0;
    for (const std::string& line : facts.place.lines)
        wide = std::max(wide, ImGui::CalcTextSize(line.c_str()).x);
    const auto lines = static_cast<float>(facts.place.lines.size());
    begin_box("place", {.x = m,
                        .y = height - 2 * m - panel_bar_height * scale,
                        .pivot_y = 1,
                        .width = wide + 2 * style.WindowPadding.x,
                        .height = lines * ImGui::GetTextLineHeightWithSpacing() - style.ItemSpacing.y +
                                  2 * style.WindowPadding.y,
                        .flags = ImGuiWindowFlags_NoInputs});
    for (const std::string& line : facts.place.lines) ImGui::TextUnformatted(line.c_str());
    ImGui::End();
}

void draw_help(const PanelFacts& facts, float width, float height, float scale) {
    begin_box("help", {.x = width / 2,
                       .y = height / 2 - panel_bar_height * scale / 2,
                       .pivot_x = 0.5F,
                       .pivot_y = 0.5F,
                       .flags = ImGuiWindowFlags_NoInputs});
    // All of it also in a small window.
    ImGui::SetWindowFontScale(std::clamp(height / (540 * scale), 0.6F, 1.0F));
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, ImVec2(6 * scale, 1 * scale));
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        const auto row = [](const std::string& key, const char* what) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            ImGui::TextColored(ImGui::GetStyle().Colors[ImGuiCol_SliderGrab], "%s", key.c_str());
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(what);
        };
        if (facts.hand) {
            row("Mouse", "drag: turn; with the right button: move");
            row("Wheel", "nearer, or farther");
            row("Middle button", "or Ctrl and the left one; double click: look at that place");
        } else {
            row("Mouse", "moves the finger; hold the left button to press");
            row("Wheel", "presses deeper or less; so does dragging with the right button");
            row("Middle button", "or Ctrl and the left one; drag: turn; with Shift: move;");
            row("", "double click: look at that place");
        }
        if (facts.hand) row("Forces", facts.hand->state.words.c_str());
        if (facts.hand && facts.hand->buttons > 0)
            row("Its buttons", "the first: forces on, and then, held down, as C; the second: forces off");
        const auto keys = key_bindings();
        for (std::size_t k = 0; k < keys.size();) {
            const bool is_other = does_nothing(keys[k].verb, facts.hand.has_value());
            std::string names, held;  // which is said once, of keys in a row
            const char* const what = keys[k].what;
            do {
                const std::string with =
                    std::string(keys[k].control ? "Ctrl " : "") + (keys[k].shift ? "Shift " : "");
                names += (names.empty() ? "" : "  ") + (with != held ? with : "") + printed(keys[k].key);
                held = with;
                ++k;
            } while (k < keys.size() && !keys[k].what);
            if (!is_other) row(names, what);
        }
        ImGui::EndTable();
    }
    ImGui::PopStyleVar();
    ImGui::End();
}

void draw_overlay_scale(const OverlayScale& scale_of, float right, float bottom, float scale) {
    const float wide = 200 * scale, tall = 12 * scale;
    begin_box("scale",
              {.x = right, .y = bottom, .pivot_x = 1, .pivot_y = 1, .flags = ImGuiWindowFlags_NoInputs});
    ImGui::TextUnformatted((scale_of.name + (scale_of.unit.empty() ? "" : ", " + scale_of.unit)).c_str());
    ImDrawList& list = *ImGui::GetWindowDrawList();
    for (const OverlayScale::Class& named : scale_of.classes) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        const float side = ImGui::GetFontSize();
        list.AddRectFilled(at, ImVec2(at.x + side, at.y + side), named.colour, 3 * scale);
        ImGui::Dummy(ImVec2(side, side));
        ImGui::SameLine();
        ImGui::TextUnformatted(named.words.c_str());
    }
    if (scale_of.classes.empty()) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        constexpr int steps = 50;
        for (int k = 0; k < steps; ++k) {
            const double share = (k + 0.5) / steps;
            list.AddRectFilled(ImVec2(at.x + wide * static_cast<float>(k) / steps, at.y),
                               ImVec2(at.x + wide * static_cast<float>(k + 1) / steps, at.y + tall),
                               ramp_colour(scale_of.least_is_light ? 1 - share : share));
        }
        ImGui::Dummy(ImVec2(wide, tall));
        const std::string least = end_of_scale(scale_of.range.least, scale_of.is_less ? "< " : ""),
                          most = end_of_scale(scale_of.range.greatest, scale_of.is_more ? "> " : "");
        ImGui::TextDisabled("%s", least.c_str());
        ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + wide - ImGui::CalcTextSize(most.c_str()).x);
        ImGui::TextDisabled("%s", most.c_str());
    }
    ImGui::End();
}

}  // namespace touchable
