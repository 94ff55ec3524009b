// SPDX-License-Identifier: Apache-2.0
// The panel on the right: finger and clip, materials, settings of touch, and performance figures.

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/authoring/segments.hpp"
#include "engine/base/words.hpp"
#include "player/window/brush.hpp"
#include "player/window/measure.hpp"
#include "player/window/panel_parts.hpp"
#include "player/window/window_panel.hpp"

namespace touchable {
namespace {

/// The clip's name, clipped to the space, and the button that resets all settings.
void draw_title(const PanelFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    const ImGuiStyle& style = ImGui::GetStyle();
    const float reset_width = 56 * scale, room = ImGui::GetContentRegionAvail().x - reset_width;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::PushClipRect(at, ImVec2(at.x + room - style.ItemSpacing.x, at.y + ImGui::GetFrameHeight()), true);
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(facts.clip.c_str());
    ImGui::PopClipRect();
    ImGui::SameLine(style.WindowPadding.x + room);
    if (ImGui::Button("reset", ImVec2(-1, 0))) asked.push_back({WindowVerb::reset});
}

/// A row of adjacent words, one of them chosen by hand; returns the clicked one, or -1. `what`: its
/// explanation.
int draw_words_row(const char* label, const std::vector<const char*>& words, int chosen, float scale,
                   const char* what) {
    draw_label(label, scale);
    const int clicked = draw_words(label, words, chosen, true);
    explain_row(what);
    return clicked;
}

void draw_pointer(const PanelFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    const int count =
        draw_words_row("fingers", {"1", "2", "3", "4", "5"}, static_cast<int>(facts.forces.size()) - 1, scale,
                       "Number of fingers round the pointer.");
    if (count >= 0) asked.push_back({WindowVerb::fingers, static_cast<double>(count + 1)});
    draw_label("depth, mm", scale);
    auto depth = static_cast<float>(facts.pressed_mm);
    const std::string depth_words = pressed_in_words(facts.pressed_mm);
    if (draw_slider("##depth", depth, -6, 12, depth_words, scale))
        asked.push_back({WindowVerb::deeper, static_cast<double>(depth) - facts.pressed_mm});
    explain_row(
        "How deep a finger presses into the surface, or how far above it stays, in millimetres of the hand. "
        "The wheel does the same.");
}

void draw_hand(const HandFacts& hand, float scale) {
    draw_label("device", scale);
    ImGui::TextUnformatted(hand.device.c_str());
    explain_row(
        "What moves the fingers. C held down: the hand moves, the fingers stay. R: its present place becomes "
        "the middle.");
    draw_label("forces", scale);
    using What = HandState::What;
    ImGui::TextUnformatted(hand.state.what == What::on     ? "on"
                           : hand.state.what == What::away ? "off: no device"
                                                           : "off");
    explain_row("Whether the device pushes back. F turns forces on or off.");
    draw_label("position", scale);
    if (std::isfinite(hand.age_s))
        ImGui::Text("%.1f ms old", 1000 * hand.age_s);
    else
        ImGui::TextUnformatted("none");
    explain_row("Age of the device's newest position. One older than 20 ms counts as none.");
    draw_label("scale", scale);
    ImGui::Text("1 m is %.3g m", hand.scene_per_metre);
    explain_row("How far a finger goes in the scene for 1 m of the hand. J: finer; K: coarser.");
}

/// Buttons for users with neither a middle button nor keys.
void draw_view(float scale, std::vector<WindowCommand>& asked) {
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x / 2, side = ImGui::GetFrameHeight();
    if (ImGui::GetContentRegionAvail().x > 12 * side) draw_label("view", scale);
    ImGui::PushButtonRepeat(true);
    if (ImGui::ArrowButton("##left", ImGuiDir_Left)) asked.push_back({WindowVerb::turn, -5});
    ImGui::SameLine(0, gap);
    if (ImGui::ArrowButton("##right", ImGuiDir_Right)) asked.push_back({WindowVerb::turn, 5});
    ImGui::SameLine(0, gap);
    if (ImGui::ArrowButton("##up", ImGuiDir_Up)) asked.push_back({WindowVerb::tilt, 5});
    ImGui::SameLine(0, gap);
    if (ImGui::ArrowButton("##down", ImGuiDir_Down)) asked.push_back({WindowVerb::tilt, -5});
    ImGui::SameLine(0, gap);
    if (ImGui::Button("+##nearer", ImVec2(side, 0))) asked.push_back({WindowVerb::nearer, 1.25});
    ImGui::SameLine(0, gap);
    if (ImGui::Button("-##farther", ImVec2(side, 0))) asked.push_back({WindowVerb::nearer, 0.8});
    ImGui::PopButtonRepeat();
    explain_row("Turns and zooms the view. So do Ctrl and the arrows, + and -, and dragging with Ctrl held.");
}

void draw_measure(const MeasureFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    const int clicked = draw_words_row(
        "measure", {"off", "on"}, facts.is_held, scale,
        "The distance of two places of the surface, in the scene: click both, or drag from one to the "
        "other. T puts the tool away and leaves the line; off removes it.");
    if (clicked == 0) asked.push_back({.verb = WindowVerb::measure, .word = "off"});
    if (clicked == 1 && !facts.is_held) asked.push_back({.verb = WindowVerb::measure});
}

/// The state of the finger and the clip.
void draw_finger(const PanelFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    if (facts.hand)
        draw_hand(*facts.hand, scale);
    else
        draw_pointer(facts, scale, asked);
    draw_label("speed", scale);
    auto speed = static_cast<float>(facts.speed);
    if (draw_slider("##rate", speed, 0.1F, 4, formatted("%.2f\xC3\x97", facts.speed), scale,
                    ImGuiSliderFlags_Logarithmic))
        asked.push_back({WindowVerb::speed, static_cast<double>(speed)});
    explain_row("How fast the clip plays. Fingers keep their own time.");
    const int loops = draw_words_row("loop", {"off", "on"}, facts.looping, scale,
                                     "Whether the clip begins again at its end. L: on or off.");
    if (loops >= 0 && (loops == 1) != facts.looping) asked.push_back({WindowVerb::loop});
    draw_label("volume", scale);
    auto volume = static_cast<float>(facts.volume);
    if (draw_slider("##volume", volume, 0, 100, formatted("%d %%", facts.volume), scale))
        asked.push_back({WindowVerb::volume, static_cast<double>(volume)});
    explain_row("How loud the clip and touch are. So do 9 and 0; M: sound off or on.");
    draw_label("colours", scale);
    if (ImGui::Button((facts.overlay + "##colours").c_str(), ImVec2(-1, 0)))
        asked.push_back({WindowVerb::overlay});
    explain_row("Colours the surface by depth, stiffness and others. A click, or O: the next.");
    const int light =
        draw_words_row("light", {light_names.begin(), light_names.end()}, static_cast<int>(facts.light),
                       scale, "How strongly relief is lit. Off: colours are the clip's own. I: the next.");
    if (light >= 0)
        asked.push_back({.verb = WindowVerb::light, .word = light_names[static_cast<std::size_t>(light)]});
    const int dents = draw_words_row(
        "dents", {"off", "on"}, facts.is_dented, scale,
        "Whether you see the surface give way under a finger, and stretch where it sticks. It changes no "
        "force.");
    if (dents >= 0) asked.push_back({WindowVerb::dent, static_cast<double>(dents)});
    draw_view(scale, asked);
    draw_measure(facts.measure, scale, asked);
    const float half = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    if (ImGui::Button(facts.force_on ? "force off" : "force on", ImVec2(half, 0)))
        asked.push_back({WindowVerb::force});
    ImGui::SameLine();
}

/// A colour chip and the name. Returns whether it was clicked.
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
    const auto rgb = material_colour(material.name);
    list.AddRectFilled(least, most, IM_COL32(rgb[0], rgb[1], rgb[2], 255), 2 * scale);
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

void draw_brush_button(const char* words, bool may, float wide, WindowVerb verb,
                       std::vector<WindowCommand>& asked) {
    ImGui::BeginDisabled(!may);
    if (ImGui::Button(words, ImVec2(wide, 0))) asked.push_back({.verb = verb});
    ImGui::EndDisabled();
}

void draw_materials(const BrushFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    const int tool = draw_words_row(
        "left button", {std::begin(brush_tools), std::end(brush_tools)}, static_cast<int>(facts.tool), scale,
        "What the left button does: touch; paint the clicked segment; join two clicked segments to one; or "
        "cut a segment by a stroke across it.");
    if (tool >= 0) asked.push_back({.verb = WindowVerb::tool, .word = brush_tools[tool]});
    draw_palette(facts, scale, asked);
    if (facts.is_there) {
        // Their material, if it is one for all, or the selected one as an alternative.
        const std::string& one = facts.otherwise.empty() ? facts.material : facts.otherwise;
        const int others =
            draw_words_row("all others", {"guessed", one.c_str()}, !facts.otherwise.empty(), scale,
                           "Unpainted places: a guess for each segment, or the material in hand for all.");
        if (others >= 0)
            asked.push_back({.verb = WindowVerb::otherwise, .word = others == 0 ? "" : facts.material});
        const int felt = draw_words_row("felt", {"before", "as painted"}, facts.materials_are_on, scale,
                                        "Without the painted materials, or with them. B switches.");
        if (felt >= 0)
            asked.push_back({.verb = WindowVerb::feel, .word = felt == 1 ? "materials on" : "materials off"});
    }
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x,
                wide = std::floor((ImGui::GetContentRegionAvail().x - 2 * gap) / 3);
    draw_brush_button("undo", facts.can_undo, wide, WindowVerb::undo, asked);
    ImGui::SameLine(0, gap);
    draw_brush_button("redo", facts.can_redo, wide, WindowVerb::redo, asked);
    ImGui::SameLine(0, gap);
    draw_brush_button("save", facts.is_there, wide, WindowVerb::save_materials, asked);
    if (facts.is_there) draw_remark(std::to_string(facts.segments) + " segments in the clip");
}

std::string value_in(const std::map<std::string, std::string>& values, const std::string& name,
                     const char* otherwise = "") {
    const auto value = values.find(name);
    return value == values.end() ? otherwise : value->second;
}

void ask_for(const SessionSetting& setting, const std::string& value, std::vector<WindowCommand>& asked) {
    asked.push_back({WindowVerb::feel, 0, setting.name + " " + value});
}

/// The value chosen by hand, otherwise the one in effect.
void draw_choice(const SessionSetting& setting, const SettingsFacts& facts,
                 std::vector<WindowCommand>& asked) {
    const bool by_hand = facts.by_hand.contains(setting.name);
    std::vector<const char*> words = setting.range.words;
    const std::string value =
        value_in(by_hand ? facts.by_hand : facts.in_effect, setting.name, words.front());
    const auto at = std::ranges::find(words, value) - words.begin();
    const int chosen = at < std::ssize(words) ? static_cast<int>(at) : -1;
    if (words.front() == std::string_view("0")) words.front() = "off";
    const int clicked = draw_words(setting.name.c_str(), words, chosen, by_hand);
    if (clicked >= 0) ask_for(setting, setting.range.words[static_cast<std::size_t>(clicked)], asked);
}

/// Each filter with its reason, one per line; separators in parentheses do not count.
void draw_reasons(const std::string& words) {
    constexpr std::string_view separators = ",;:", stated = "(stated)";
    int depth = 0;
    std::string line;
    for (std::size_t k = 0; k < words.size(); ++k) {
        depth += words[k] == '(' ? 1 : (words[k] == ')' ? -1 : 0);
        const bool is_last = k + 1 == words.size(),
                   ends = !is_last && depth == 0 && words[k + 1] == ' ' &&
                          separators.find(words[k]) != std::string_view::npos;
        if (!ends) line += words[k];
        if (!ends && !is_last) continue;
        if (const std::size_t at = line.find(stated); at != std::string::npos)
            line.replace(at, stated.size(), "(asked for)");
        draw_remark(line);
        line.clear();
        ++k;  // the space
    }
}

std::string shown_number(const SessionSetting& setting, float value) {
    return formatted(setting.range.whole ? "%.0f" : (setting.range.by_ratio ? "%.3g" : "%.2g"),
                     static_cast<double>(value));
}

struct DrawnCurve {
    const Curve& curve;
    ImU32 colour;
};

/// Overlaid lines from 0 to `most`, or a bar for each value; the newest value as text on the right.
void draw_curves(const char* label, const std::vector<DrawnCurve>& curves, float most, bool bars,
                 const char* words, float scale) {
    const float tall = 30 * scale, down = (tall - ImGui::GetFrameHeight()) / 2;
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + down);
    draw_label(label, scale);
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() - down);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float wide = value_column(scale);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(at, ImVec2(at.x + wide, at.y + tall), ImGui::GetColorU32(ImGuiCol_FrameBg), 4 * scale);
    std::array<ImVec2, Curve::most> points;
    for (const DrawnCurve& drawn : curves) {
        for (std::size_t k = 0; k < Curve::most; ++k) {
            const float share = std::clamp(drawn.curve[k] / most, 0.0F, 1.0F);
            points[k] = ImVec2(at.x + wide * (static_cast<float>(k) + 0.5F) / Curve::most,
                               at.y + tall - 1 - share * (tall - 3));
        }
        if (!bars) {
            list.AddPolyline(points.data(), static_cast<int>(points.size()), drawn.colour, 0, 1.5F * scale);
            continue;
        }
        for (std::size_t k = 0; k < Curve::most; ++k)
            if (drawn.curve[k] > 0)
                list.AddLine(ImVec2(points[k].x, at.y + tall - 1), points[k], drawn.colour, 2 * scale);
    }
    ImGui::Dummy(ImVec2(wide, tall));
    draw_value(words, at.x + wide, at.y + (tall - ImGui::GetFontSize()) / 2);
}

}  // namespace

void WindowPanel::draw_side(const PanelFacts& facts, float width, float height,
                            std::vector<WindowCommand>& asked) {
    const bool roomy = is_roomy(width), tall = height > 600 * scale_;
    const float m = panel_margin * scale_, scale = roomy ? scale_ : 0.86F * scale_;
    // Keeps the picture visible, as the settings affect it.
    if (!roomy) ImGui::SetNextWindowBgAlpha(0.7F);
    begin_box("panel", {.x = width - m,
                        .y = m,
                        .pivot_x = 1,
                        .width = side_width(width),
                        .height = height - 3 * m - panel_bar_height * scale_,
                        .scrolls = true,
                        .has_keys = has_focus && !menu_at});
    note_box();
    ImGui::SetWindowFontScale(scale / scale_);
    const ImGuiStyle& style = ImGui::GetStyle();
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(style.FramePadding.x, 2 * scale));
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(style.ItemSpacing.x, 4 * scale));
    draw_title(facts, scale, asked);
    draw_finger(facts, scale, asked);
    if (ImGui::Button("menu", ImVec2(-1, 0))) menu_at.emplace(0.0);  // for touch screens
    // Opens the materials when a tool is taken.
    const bool is_held = facts.brush.tool != BrushTool::touch;
    if (std::exchange(tool_was_held_, is_held) != is_held) ImGui::SetNextItemOpen(is_held);
    if (draw_fold("Materials", false)) draw_materials(facts.brush, scale, asked);
    if (draw_fold("What is felt", true)) settings_.draw(SettingOf::felt, facts.settings, scale, asked);
    if (draw_fold("Filters of depth", tall)) settings_.draw(SettingOf::filters, facts.settings, scale, asked);
    if (draw_fold("Relief of colour", tall)) settings_.draw(SettingOf::relief, facts.settings, scale, asked);
    if (draw_fold("How it goes", tall)) {
        curves_.draw(facts.limit_newtons, scale);
        for (const std::string& line : facts.figures) draw_remark(line);
    }
    ImGui::PopStyleVar(2);
    ImGui::End();
}

float WindowPanel::side_width(float width) const {
    return is_roomy(width) ? 310 * scale_ : std::min(250 * scale_, width * 0.44F);
}

void SettingsPanel::draw(SettingOf of, const SettingsFacts& facts, float scale,
                         std::vector<WindowCommand>& asked) {
    scale_ = scale;
    if (of == SettingOf::felt) {
        const int set = draw_words_row(
            "settings", {"A", "B"}, facts.b_is_on, scale_,
            "Two sets of settings, to feel the difference. The key B switches. Set B begins without filters, "
            "or, where materials are painted, without those.");
        if (set >= 0) asked.push_back({WindowVerb::settings, 0, set == 0 ? "a" : "b"});
    }
    for (const SessionSetting& setting : session_settings())
        if (setting.name != "metric" &&  // for the paper's experiments, by its option
            (setting.of == of ||
             (of == SettingOf::felt && setting.of == SettingOf::device && facts.has_device)))
            draw_row(setting, facts, asked);
    if (of == SettingOf::filters) draw_reasons(facts.filters);
    if (of == SettingOf::relief && !facts.relief.empty()) draw_remark(facts.relief);
}

void SettingsPanel::draw_row(const SessionSetting& setting, const SettingsFacts& facts,
                             std::vector<WindowCommand>& asked) {
    std::string label = setting.name == "filters" ? "all at once" : setting.name;
    std::ranges::replace(label, '-', ' ');
    draw_label(label, scale_);
    if (setting.range.words.empty())
        draw_number(setting, facts, asked);
    else
        draw_choice(setting, facts, asked);
    explain_row(setting.what);
}

/// Takes effect when the slider is released.
void SettingsPanel::draw_number(const SessionSetting& setting, const SettingsFacts& facts,
                                std::vector<WindowCommand>& asked) {
    const SettingRange& range = setting.range;
    const auto known = parsed_number(value_in(facts.in_effect, setting.name));
    const double in_effect = known.value_or(range.least);
    const std::string id = "##" + setting.name;
    auto value = held_ == setting.name ? dragged_ : static_cast<float>(in_effect);
    const std::string number = shown_number(setting, value);
    const bool may_be_off = (setting.of == SettingOf::filters || setting.name == "relief") && range.whole;
    const bool is_other = !known && held_ != setting.name;  // filters that no detail stands for
    const std::string words = is_other                      ? "as stated"
                              : may_be_off && number == "0" ? "off"
                                                            : number + " " + range.unit;
    draw_slider(id.c_str(), value, static_cast<float>(range.least), static_cast<float>(range.most), words,
                scale_, range.by_ratio ? ImGuiSliderFlags_Logarithmic : 0);
    if (ImGui::IsItemActive()) {
        held_ = setting.name;
        dragged_ = value;
    } else if (held_ == setting.name) {
        held_.clear();
    }
    if (ImGui::IsItemDeactivatedAfterEdit()) ask_for(setting, shown_number(setting, dragged_), asked);
}

void CurvesPanel::remember(const PanelFacts& facts, double picture_ms, double tick_us) {
    for (std::size_t k = 0; k < forces_.size(); ++k)
        forces_[k].add(k < facts.forces.size() ? facts.forces[k] : 0);
    picture_ms_.add(picture_ms);
    tick_us_.add(tick_us);
    // A new session counts from 0 again.
    late_ticks_.add(static_cast<double>(std::max<std::int64_t>(facts.late_ticks - all_late_, 0)));
    dropped_frames_.add(static_cast<double>(std::max<std::int64_t>(facts.dropped_frames - all_dropped_, 0)));
    all_late_ = facts.late_ticks;
    all_dropped_ = facts.dropped_frames;
}

void CurvesPanel::draw(double most_newtons, float scale) {
    const ImU32 usual = ImGui::GetColorU32(ImGuiCol_PlotLines);
    const ImU32 bad = IM_COL32(240, 150, 90, 255);
    float newtons = 0;
    for (const Curve& curve : forces_) newtons = std::max(newtons, curve.newest());
    std::vector<DrawnCurve> forces;
    for (std::size_t k = forces_.size(); k-- > 0;) forces.push_back({forces_[k], readable_finger_colour(k)});
    draw_curves("force", forces, static_cast<float>(most_newtons), false,
                formatted("%.1f N", static_cast<double>(newtons)).c_str(), scale);
    explain_row("Newtons on each finger, in its colour.");
    draw_curves("picture", {{picture_ms_, usual}}, std::max(50.0F, picture_ms_.greatest()), false,
                formatted("%.0f ms", static_cast<double>(picture_ms_.newest())).c_str(), scale);
    explain_row("How long a picture takes to draw. At 33 ms there are 30 a second.");
    draw_curves("tick", {{tick_us_, usual}}, std::max(50.0F, tick_us_.greatest()), false,
                formatted("%.0f \xC2\xB5s", static_cast<double>(tick_us_.newest())).c_str(), scale);
    explain_row(
        "How long a force takes to compute. There are 1000 a second: below 1000 \xC2\xB5s all is well.");
    draw_curves("late ticks", {{late_ticks_, bad}}, std::max(2.0F, late_ticks_.greatest()), true,
                formatted("%lld", static_cast<long long>(all_late_)).c_str(), scale);
    explain_row("Forces that came a millisecond or more too late.");
    draw_curves("left out", {{dropped_frames_, bad}}, std::max(2.0F, dropped_frames_.greatest()), true,
                formatted("%lld", static_cast<long long>(all_dropped_)).c_str(), scale);
    explain_row("Frames of the clip that this machine had no time for.");
}

float Curve::greatest() const {
    return *std::ranges::max_element(values_);
}

}  // namespace touchable
