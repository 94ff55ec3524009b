// SPDX-License-Identifier: Apache-2.0
// Over the picture: boxes in its corners, lines of the measure and the brush, help, and the page of a window
// without a clip.

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/words.hpp"
#include "player/draw/overlays.hpp"
#include "player/window/command_table.hpp"
#include "player/window/panel_parts.hpp"
#include "player/window/window_command.hpp"

namespace touchable {
namespace {

/// Spacing of the lines across the force bar: a round number of newtons, for three to seven lines.
double newtons_of_line(double limit) {
    const double decade = std::pow(10.0, std::floor(std::log10(limit)));
    const double lead = limit / decade;
    return decade * (lead < 1.5 ? 0.25 : (lead < 3 ? 0.5 : (lead < 6 ? 1 : 2)));
}

/// `beyond`: a prefix if values beyond the end have the same colour.
std::string end_of_scale(double value, const char* beyond) {
    return beyond + formatted("%.4g", value);
}

/// A colour and its meaning, no wider than `room`.
void draw_class(PackedColour colour, const char* words, float room, float scale) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float side = ImGui::GetFontSize(), end = ImGui::GetCursorPosX() + room;
    ImGui::GetWindowDrawList()->AddRectFilled(at, ImVec2(at.x + side, at.y + side), colour, 3 * scale);
    ImGui::Dummy(ImVec2(side, side));
    ImGui::SameLine();
    ImGui::PushTextWrapPos(end);
    ImGui::TextUnformatted(words);
    ImGui::PopTextWrapPos();
}

/// The ramp, with its ends below; also the middle, if the scale is not linear and there is room.
void draw_ramp(const Overlays::Scale& scale_of, float room, float scale) {
    const float wide = std::min(220 * scale, room), tall = 12 * scale;
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
    // `part`: the share of the text left of the place.
    const auto draw_at = [&](float place, const std::string& words, float part) {
        ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + place -
                        part * ImGui::CalcTextSize(words.c_str()).x);
        ImGui::TextDisabled("%s", words.c_str());
    };
    ImGui::TextDisabled("%s", end_of_scale(scale_of.range.least, scale_of.is_less ? "< " : "").c_str());
    if (!scale_of.levels.empty() && wide > 180 * scale)
        draw_at(wide / 2, formatted("%.3g", scale_of.levels[scale_of.levels.size() / 2]), 0.5F);
    draw_at(wide, end_of_scale(scale_of.range.greatest, scale_of.is_more ? "> " : ""), 1);
}

constexpr ImU32 line_rim = IM_COL32(0, 0, 0, 200), line_ink = IM_COL32(255, 255, 255, 255),
                frozen_ink = IM_COL32(255, 200, 110, 255);

void draw_end(ImDrawList& list, const ImVec2& at, ImU32 ink, float scale) {
    list.AddCircle(at, 6 * scale, line_rim, 0, 4 * scale);
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

using HelpRow = HelpGroup::Row;

/// A key's name as keyboards print it.
std::string printed(std::string key) {
    if (key == "pageup") return "PageUp";
    if (key == "pagedown") return "PageDown";
    if (key[0] >= 'a' && key[0] <= 'z') key[0] = static_cast<char>(key[0] - 'a' + 'A');
    return key;
}

/// Actions without a key.
std::vector<HelpRow> gestures(CommandRow::Topic topic, const PanelFacts& facts) {
    std::vector<HelpRow> rows;
    if (topic == CommandRow::Topic::begin && facts.hand) {
        rows = {{"Drag", "turns the view; with the right button: moves it"}, {"Wheel", "nearer or farther"}};
    } else if (topic == CommandRow::Topic::begin) {
        rows = {{"Left button", "hold it down: the finger presses"},
                {"Right button", "drag down: presses deeper, up: less; a click: menu"},
                {"Ctrl and drag", "turns the view; also the middle button"}};
        if (facts.has_touch_screen)
            rows.push_back({"Touch screen", "each finger touches; two at once turn the view and zoom"});
    } else if (topic == CommandRow::Topic::touch && facts.hand) {
        rows = {{"Forces", facts.hand->state.words}};
        if (facts.hand->buttons > 0)
            rows.push_back({"Its buttons", "the first: forces on; then held down: as C"});
        if (facts.hand->buttons > 1) rows.push_back({"", "the second: forces off"});
    } else if (topic == CommandRow::Topic::touch) {
        rows = {{"Wheel", "presses deeper or less deep, and stays so"}};
    } else if (topic == CommandRow::Topic::view) {
        if (!facts.hand) rows = {{"Ctrl Shift drag", "moves the view; also Shift and the middle button"}};
        rows.push_back({"Middle button", "double click: the view turns round that place"});
    } else if (topic == CommandRow::Topic::window) {
        rows = {{"Drop", "a file or folder, or several: opens them"}};
    }
    return rows;
}

/// The keys of a row. A key that does the same with Shift, or a larger step, is named once.
std::string names_of(std::span<const KeyBinding> row) {
    std::string names, held;
    for (std::size_t k = 0; k < row.size(); ++k) {
        const auto is_same = [&](const KeyBinding& before) {
            return before.key == std::string(row[k].key) && before.control == row[k].control &&
                   before.verb == row[k].verb;
        };
        if (std::any_of(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(k), is_same)) continue;
        const std::string with = std::string(row[k].control ? "Ctrl " : "") + (row[k].shift ? "Shift " : "");
        names += (names.empty() ? "" : "  ") + (with != held ? with : "") + printed(row[k].key);
        held = with;
    }
    return names;
}

constexpr float title_lines = 1.3F, gap_lines = 0.6F, smallest_share = 12.0F / 15;

/// The groups of a column, and the widths of its text, at full size.
struct HelpColumn {
    std::span<const HelpGroup> groups;
    float keys = 0, whole = 0, lines = 0;

    HelpColumn(std::span<const HelpGroup> of, float gap) : groups(of) {
        float what = 0;
        for (const HelpGroup& group : groups) {
            lines += title_lines + static_cast<float>(group.rows.size()) + gap_lines;
            for (const HelpRow& row : group.rows) {
                keys = std::max(keys, ImGui::CalcTextSize(row.keys.c_str()).x + gap);
                what = std::max(what, ImGui::CalcTextSize(row.what.c_str()).x);
            }
        }
        lines -= gap_lines;
        whole = keys + what;
    }
};

/// Two columns of about the same height.
std::vector<HelpColumn> two_columns(std::span<const HelpGroup> groups, float gap) {
    std::vector<HelpColumn> best;
    float tallest = 0;
    for (std::size_t k = 1; k < groups.size(); ++k) {
        const HelpColumn left(groups.first(k), gap), right(groups.subspan(k), gap);
        const float tall = std::max(left.lines, right.lines);
        if (!best.empty() && tall >= tallest) continue;
        tallest = tall;
        best = {left, right};
    }
    return best;
}

void draw_column(const HelpColumn& column, ImVec2 at, float line, float share) {
    const ImVec4* const colours = ImGui::GetStyle().Colors;
    const auto write = [](const ImVec2& place, const ImVec4& colour, const std::string& words) {
        ImGui::SetCursorPos(place);
        ImGui::TextColored(colour, "%s", words.c_str());
    };
    for (const HelpGroup& group : column.groups) {
        write(at, colours[ImGuiCol_Text], group.title);
        const ImVec2 rule(ImGui::GetWindowPos().x + at.x,
                          ImGui::GetWindowPos().y - ImGui::GetScrollY() + at.y + 1.1F * line);
        ImGui::GetWindowDrawList()->AddLine(rule, ImVec2(rule.x + share * column.whole, rule.y),
                                            ImGui::GetColorU32(ImGuiCol_SliderGrab, 0.5F), line / 16);
        at.y += title_lines * line;
        for (const HelpRow& row : group.rows) {
            write(at, colours[ImGuiCol_SliderGrab], row.keys);
            write(ImVec2(at.x + share * column.keys, at.y), colours[ImGuiCol_Text], row.what);
            at.y += line;
        }
        at.y += gap_lines * line;
    }
}

/// Covers the last line while there is more below.
void draw_more(float scale) {
    if (ImGui::GetScrollY() >= ImGui::GetScrollMaxY() - 1) return;
    const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    const float bar = ImGui::GetStyle().ScrollbarSize, tall = ImGui::GetFontSize() + 8 * scale;
    const char* const words = "more below: turn the wheel, or drag the bar on the right";
    const ImVec2 least(at.x, at.y + size.y - tall), most(at.x + size.x - bar, at.y + size.y);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRect(at, most);
    list.AddRectFilled(least, most, IM_COL32(28, 42, 58, 255));
    const float left = (least.x + most.x - ImGui::CalcTextSize(words).x) / 2;
    list.AddText(ImVec2(std::max(left, least.x + 4 * scale), least.y + 4 * scale),
                 IM_COL32(255, 255, 255, 255), words);
    list.PopClipRect();
}

constexpr const char* other_things =
    "or several; a folder of pictures; a photo with depth; a recording of a camera";

/// Hints for users without a clip.
constexpr struct {
    const char *wish, *command;
} ways[] = {{"choose one", "a click, or Ctrl O"},
            {"make one", "touchable make globe globe.mkv"},
            {"what can be opened", "touchable formats"},
            {"a depth camera that is plugged in", "touchable cameras"},
            {"close", "Q, or Escape"}};

}  // namespace

void draw_force(const PanelFacts& facts, float height, float scale) {
    constexpr double beyond_limit = 1.08;  // so that the limit's mark has bar on either side
    const float m = panel_margin * scale;
    const auto fingers = static_cast<float>(std::max<std::size_t>(facts.forces.size(), 1));
    const float each = std::min(18 * scale, 180 * scale / fingers);
    const float bar = each * 2 / 3, gap = each / 3, tall = std::min(150 * scale, height * 0.3F);
    // ImGui sizes a box by its content a picture later, so known sizes are set.
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
    if (facts.force_on || facts.kiosk)  // a kiosk shows it in large text, in its own words
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

void draw_place(const PanelFacts& facts, float width, float height, float scale) {
    std::vector<std::string> words = facts.place.lines;
    const float m = panel_margin * scale, bottom = height - 2 * m - panel_bar_height * scale;
    // A place behind the bar or the panel is not described, and a button's explanation takes the space.
    if (words.empty() || ImGui::IsWindowHovered(ImGuiHoveredFlags_AnyWindow)) return;
    // As large as fits, but legible; lines that then do not fit are dropped.
    const ImVec2 padding = ImGui::GetStyle().WindowPadding;
    const float font = ImGui::GetFontSize(), gap = 2 * scale, room = height / 5 - 2 * padding.y;
    const float wide_room = width / 2 - 2 * padding.x;
    const auto tall = [&](float share) {
        return static_cast<float>(words.size()) * (share * font + gap) - gap;
    };
    const auto wide = [](const std::string& line) { return ImGui::CalcTextSize(line.c_str()).x; };
    const auto is_wide = [&](const std::string& line) { return smallest_share * wide(line) > wide_room; };
    words.erase(std::remove_if(words.begin() + 1, words.end(), is_wide), words.end());
    while (words.size() > 1 && tall(smallest_share) > room) words.pop_back();
    float widest = 0;
    for (const std::string& line : words) widest = std::max(widest, wide(line));
    const float share = std::clamp(std::min((room - tall(0)) / (tall(1) - tall(0)), wide_room / widest),
                                   smallest_share, 1.0F);
    begin_box("place", {.x = m,
                        .y = bottom,
                        .pivot_y = 1,
                        .width = share * widest + 2 * padding.x,
                        .height = tall(share) + 2 * padding.y,
                        .flags = ImGuiWindowFlags_NoInputs});
    ImGui::SetWindowFontScale(share);
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(gap, gap));
    for (const std::string& line : words) ImGui::TextUnformatted(line.c_str());
    ImGui::PopStyleVar();
    ImGui::End();
}

void draw_overlay_scale(const Overlays::Scale& scale_of, float right, float bottom, float room, float scale) {
    const bool is_small = room < widest_scale * scale;
    const float pad = (is_small ? 0.5F : 1) * ImGui::GetStyle().WindowPadding.x, text = room - 2 * pad;
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(pad, pad));
    begin_box("scale",
              {.x = right, .y = bottom, .pivot_x = 1, .pivot_y = 1, .flags = ImGuiWindowFlags_NoInputs});
    if (is_small) ImGui::SetWindowFontScale(smallest_share);
    const std::string everywhere = scale_of.everywhere();
    std::string title = everywhere.empty() ? scale_of.title() : scale_of.name;
    if (ImGui::CalcTextSize(title.c_str()).x > text) title = scale_of.name;
    ImGui::TextUnformatted(title.c_str());
    for (const Overlays::Scale::Class& named : scale_of.classes)
        draw_class(named.colour, named.words.c_str(), text, scale);
    if (!everywhere.empty()) draw_class(ramp_colour(0.5), everywhere.c_str(), text, scale);
    if (scale_of.classes.empty() && everywhere.empty()) draw_ramp(scale_of, text, scale);
    ImGui::End();
    ImGui::PopStyleVar();
}

void draw_measured_line(const MeasureFacts& facts, float scale) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const ImU32 ink = facts.is_frozen ? frozen_ink : line_ink;
    if (facts.next) draw_end(list, point_of(*facts.next), line_ink, scale);
    if (facts.ends.size() == 1) draw_end(list, point_of(facts.ends[0]), ink, scale);
    if (facts.ends.size() != 2) return;
    const ImVec2 from = point_of(facts.ends[0]), to = point_of(facts.ends[1]);
    list.AddLine(from, to, line_rim, 5 * scale);
    list.AddLine(from, to, ink, 2 * scale);
    draw_end(list, from, ink, scale);
    draw_end(list, to, ink, scale);
    draw_length(list, ImVec2((from.x + to.x) / 2, (from.y + to.y) / 2), facts.words, ink, scale);
}

void draw_brush_line(const BrushFacts& facts, float scale) {
    if (facts.line.empty()) return;
    std::vector<ImVec2> points;
    for (const glm::dvec2& at : facts.line) points.push_back(point_of(at));
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto count = static_cast<int>(points.size());
    list.AddPolyline(points.data(), count, line_rim, 0, 5 * scale);
    list.AddPolyline(points.data(), count, line_ink, 0, 2 * scale);
    list.AddCircleFilled(points.front(), 5 * scale, line_rim);
    list.AddCircleFilled(points.front(), 3 * scale, line_ink);
}

std::string keys_of(WindowVerb verb) {
    const auto key = std::ranges::find(key_bindings(), verb, &KeyBinding::verb);
    return key == key_bindings().end() ? "" : names_of({key, 1});
}

std::vector<HelpGroup> help_groups(const PanelFacts& facts) {
    static constexpr const char* titles[] = {"To begin with",      "Touch",           "Look around", "Play",
                                             "Data and materials", "Window and files"};
    const auto does_nothing = facts.hand ? CommandRow::of_pointer : CommandRow::of_hand;
    const auto keys = key_bindings();
    std::vector<HelpGroup> groups;
    for (std::size_t begin = 0, end = 0; begin < keys.size(); begin = end) {
        const auto topic = keys[begin].topic;
        if (const auto at = static_cast<std::size_t>(topic); at == groups.size())
            groups.push_back({titles[at], gestures(topic, facts)});
        do ++end;
        while (end < keys.size() && !keys[end].what);
        if (row_of(keys[begin].verb).has(does_nothing)) continue;
        groups.back().rows.push_back({names_of(keys.subspan(begin, end - begin)), keys[begin].what});
    }
    return groups;
}

void begin_help(const PanelFacts& facts, float width, float height, float scale) {
    const std::vector<HelpGroup> groups = help_groups(facts);
    const ImGuiStyle& style = ImGui::GetStyle();
    const ImVec2 padding(style.WindowPadding.x + 4 * scale, style.WindowPadding.y);
    const float m = panel_margin * scale, tall_room = height - 3 * m - panel_bar_height * scale,
                wide_room = width - 2 * m, full_line = ImGui::GetFontSize() + 2 * scale;
    const float gap = 14 * scale, between = 34 * scale;
    std::vector<HelpColumn> columns = two_columns(groups, gap);
    const auto full_width = [&] {
        float wide = between * static_cast<float>(columns.size() - 1);
        for (const HelpColumn& column : columns) wide += column.whole;
        return wide;
    };
    // Scrolling takes the scrollbar's width.
    const float words_room = wide_room - 2 * padding.x - style.ScrollbarSize;
    if (words_room / full_width() < smallest_share) columns = {HelpColumn(groups, gap)};
    const float lines = std::ranges::max(columns, {}, &HelpColumn::lines).lines,
                by_height = (tall_room - 2 * padding.y) / (lines * full_line);
    const float share = std::clamp(std::min(words_room / full_width(), by_height), smallest_share, 1.0F),
                line = share * full_line;
    const bool scrolls = by_height < smallest_share;
    const float wide = 2 * padding.x + (scrolls ? style.ScrollbarSize : 0) + share * full_width(),
                tall = lines * line + 2 * padding.y;
    begin_box("help", {.x = width / 2,
                       .y = m + tall_room / 2,
                       .pivot_x = 0.5F,
                       .pivot_y = 0.5F,
                       .width = std::min(wide, wide_room),
                       .height = std::min(tall, tall_room),
                       .flags = scrolls ? 0 : ImGuiWindowFlags_NoScrollWithMouse,
                       .scrolls = scrolls});
    ImGui::SetWindowFontScale(share);
    ImVec2 at = padding;
    for (const HelpColumn& column : columns) {
        draw_column(column, at, line, share);
        at.x += share * (column.whole + between);
    }
    if (!scrolls) return;
    // The last line ends above the hint that there is more.
    ImGui::SetCursorPos(ImVec2(0, lines * line + padding.y));
    ImGui::Dummy(ImVec2(1, line));
    draw_more(scale);
}

void begin_files(const FileList& files, float top, float width, float bottom, float scale,
                 std::vector<WindowCommand>& asked) {
    const float wide = std::min(520 * scale, width - 2 * panel_margin * scale);
    ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(width, std::max(bottom - top, 60 * scale)));
    ImGui::SetNextWindowBgAlpha(0.95F);
    begin_box("files",
              {.x = width / 2, .y = top, .pivot_x = 0.5F, .width = wide, .scrolls = true, .has_keys = true});
    if (!files.folder.empty())
        draw_remark(files.folder.string() + "; arrows and Enter, or a click: opens; Escape: closes");
    for (const FileList::Row& row : files.rows) {
        ImGui::PushID(row.path.c_str());
        if (ImGui::Selectable(row.words.c_str()))
            asked.push_back(
                {.verb = row.is_folder ? WindowVerb::choose : WindowVerb::open, .word = row.path.string()});
        ImGui::PopID();
    }
}

float draw_empty_page(std::size_t recent, float width, float height, float scale) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    ImFont* const large = ImGui::GetIO().Fonts->Fonts.back();
    ImFont* const font = ImGui::GetFont();
    const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text), dim = ImGui::GetColorU32(ImGuiCol_TextDisabled),
                accent = ImGui::GetColorU32(ImGuiCol_SliderGrab);
    const float size = ImGui::GetFontSize(), line = 1.6F * size, gap = 1.5F * size;
    const auto wide = [&](ImFont* of, float at, float wrap, const char* words) {
        return of->CalcTextSizeA(at, 1e6F, wrap, words);
    };
    const float room = 0.9F * width, plain = wide(large, 1, 0, empty_page_title).x;
    const float title_size = std::clamp(room / plain, size, 48 * scale);
    const auto shown = std::span(ways).first(recent == 0 ? std::size(ways) : 1);
    float wish = 0, command = 0;
    for (const auto& way : shown) {
        wish = std::max(wish, wide(font, size, 0, way.wish).x);
        command = std::max(command, wide(font, size, 0, way.command).x);
    }
    const ImVec2 whole = wide(font, size, room, other_things);
    const float tall = 1.5F * title_size + whole.y + gap + line * static_cast<float>(shown.size() + recent);
    float y = std::max((height - tall) / 2, size);
    list.AddText(large, title_size, ImVec2((width - plain * title_size) / 2, y), ink, empty_page_title);
    y += 1.5F * title_size;
    list.AddText(font, size, ImVec2((width - whole.x) / 2, y), dim, other_things, nullptr, room);
    y += whole.y + gap;
    const float left = std::max((width - wish - gap - command) / 2, size / 2);
    for (const auto& way : shown) {
        list.AddText(font, size, ImVec2(left, y), dim, way.wish);
        list.AddText(font, size, ImVec2(left + wish + gap, y), accent, way.command);
        y += line;
    }
    return y;
}

}  // namespace touchable
