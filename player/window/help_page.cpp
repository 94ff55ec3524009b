#include "player/window/help_page.hpp"

#include <imgui.h>

#include <algorithm>
#include <span>
#include <utility>

#include "player/window/corner_panels.hpp"
#include "player/window/window_command.hpp"

namespace touchable {
namespace {

using Row = HelpGroup::Row;
using Topic = KeyGroup::Topic;

/// A key's name as keyboards print it.
std::string printed(std::string key) {
    if (key == "pageup") return "PageUp";
    if (key == "pagedown") return "PageDown";
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

/// What is done without a key.
std::vector<Row> gestures(Topic topic, const PanelFacts& facts) {
    std::vector<Row> rows;
    if (topic == Topic::begin && facts.hand) {
        rows = {{"Drag", "turns the view; with the right button: moves it"}, {"Wheel", "nearer, or farther"}};
    } else if (topic == Topic::begin) {
        rows = {{"Left button", "hold it down: the finger presses"},
                {"Right button", "drag down: presses deeper, and stays so; up: less"},
                {"Ctrl and drag", "turns the view; so does the middle button"}};
        if (facts.has_touch_screen)
            rows.push_back({"Touch screen", "each finger touches; two at once turn the view and zoom"});
    } else if (topic == Topic::touch && facts.hand) {
        rows = {{"Forces", facts.hand->state.words}};
        if (facts.hand->buttons > 0)
            rows.push_back({"Its buttons", "the first: forces on; then, held down, as C"});
        if (facts.hand->buttons > 1) rows.push_back({"", "the second: forces off"});
    } else if (topic == Topic::touch) {
        rows = {{"Wheel", "presses deeper, or less, and stays so"}};
    } else if (topic == Topic::view) {
        if (!facts.hand) rows = {{"Ctrl Shift drag", "moves the view; so does Shift and the middle button"}};
        rows.push_back({"Middle button", "double click: turn round that place from now on"});
    } else if (topic == Topic::window) {
        rows = {{"Drop", "a file, a folder, or several: shows them"}};
    }
    return rows;
}

/// The keys of one row. One that does the same with Shift, or more of it, is named once.
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

constexpr float title_lines = 1.3F, gap_lines = 0.6F, smallest = 12.0F / 15;

/// The groups of one column, and how wide its words are, at full size.
struct Column {
    std::span<const HelpGroup> groups;
    float keys = 0, whole = 0, lines = 0;

    Column(std::span<const HelpGroup> of, float gap) : groups(of) {
        float what = 0;
        for (const HelpGroup& group : groups) {
            lines += title_lines + static_cast<float>(group.rows.size()) + gap_lines;
            for (const Row& row : group.rows) {
                keys = std::max(keys, ImGui::CalcTextSize(row.keys.c_str()).x + gap);
                what = std::max(what, ImGui::CalcTextSize(row.what.c_str()).x);
            }
        }
        lines -= gap_lines;
        whole = keys + what;
    }
};

/// Two of about the same height.
std::vector<Column> two_columns(std::span<const HelpGroup> groups, float gap) {
    std::vector<Column> best;
    float tallest = 0;
    for (std::size_t k = 1; k < groups.size(); ++k) {
        const Column left(groups.first(k), gap), right(groups.subspan(k), gap);
        const float tall = std::max(left.lines, right.lines);
        if (!best.empty() && tall >= tallest) continue;
        tallest = tall;
        best = {left, right};
    }
    return best;
}

void draw_column(const Column& column, ImVec2 at, float line, float share) {
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
        for (const Row& row : group.rows) {
            write(at, colours[ImGuiCol_SliderGrab], row.keys);
            write(ImVec2(at.x + share * column.keys, at.y), colours[ImGuiCol_Text], row.what);
            at.y += line;
        }
        at.y += gap_lines * line;
    }
}

/// Over the last line, as long as there is something below it.
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

}  // namespace

std::vector<HelpGroup> help_groups(const PanelFacts& facts) {
    std::vector<HelpGroup> groups;
    for (const KeyGroup& of : key_groups()) {
        HelpGroup group{of.title, gestures(of.topic, facts)};
        for (std::size_t begin = 0, end = 0; begin < of.keys.size(); begin = end) {
            do ++end;
            while (end < of.keys.size() && !of.keys[end].what);
            if (does_nothing(of.keys[begin].verb, facts.hand.has_value())) continue;
            group.rows.push_back({names_of(of.keys.subspan(begin, end - begin)), of.keys[begin].what});
        }
        groups.push_back(std::move(group));
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
    // Of one that is scrolled the bar takes some of the width.
    const auto share_of = [&](const std::vector<Column>& columns) {
        float wide = between * static_cast<float>(columns.size() - 1), lines = 0;
        for (const Column& column : columns) wide += column.whole, lines = std::max(lines, column.lines);
        return std::pair((wide_room - 2 * padding.x - style.ScrollbarSize) / wide,
                         (tall_room - 2 * padding.y) / (lines * full_line));
    };
    std::vector<Column> columns = two_columns(groups, gap);
    if (share_of(columns).first < smallest) columns = {Column(groups, gap)};
    const auto [by_width, by_height] = share_of(columns);
    const float share = std::clamp(std::min(by_width, by_height), smallest, 1.0F), line = share * full_line;
    const bool scrolls = by_height < smallest;
    float wide = 2 * padding.x + (scrolls ? style.ScrollbarSize : 0), lines = 0;
    for (const Column& column : columns) wide += share * column.whole, lines = std::max(lines, column.lines);
    wide += share * between * static_cast<float>(columns.size() - 1);
    const float tall = lines * line + 2 * padding.y;
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
    for (const Column& column : columns) {
        draw_column(column, at, line, share);
        at.x += share * (column.whole + between);
    }
    if (!scrolls) return;
    // The last line ends above the words that say that there is more.
    ImGui::SetCursorPos(ImVec2(0, lines * line + padding.y));
    ImGui::Dummy(ImVec2(1, line));
    draw_more(scale);
}

}  // namespace touchable
