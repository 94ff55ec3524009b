// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_panel.hpp"

#include <imgui.h>

#include "engine/base/words.hpp"
#include "player/window/panel_parts.hpp"

namespace touchable {
namespace {

const ImVec4 bad_words(1.0F, 0.62F, 0.45F, 1);

std::string clock_words(double seconds) {
    const auto tenths = static_cast<long>(std::floor(std::max(seconds, 0.0) * 10 + 0.5));
    return formatted("%ld:%02ld.%ld", tenths / 600, tenths / 10 % 60, tenths % 10);
}

/// Width of the text with any other digits.
float wide_digits(std::string words) {
    for (char& letter : words)
        if (letter >= '0' && letter <= '9') letter = '0';
    return ImGui::CalcTextSize(words.c_str()).x;
}

/// Ordered from dispensable to needed; the first are dropped when room is short. The panel behind `settings`
/// has all, too, and its menu has the house.
enum class Need { colours, loop, speed, other_clip, measure, turn, settings, home, always };

struct BarButton {
    std::string words;  ///< with an ImGui id after ##
    const char* what;   ///< tooltip
    Need need;
    WindowCommand command;
    bool is_lit = false;
    ButtonSign sign = ButtonSign::none;
    float width = 0;  ///< 0: fits its text

    float wide(float side) const {
        if (sign != ButtonSign::none) return side;
        const float words_wide = ImGui::CalcTextSize(words.c_str(), nullptr, true).x;
        return std::max({side, width, words_wide + 2 * ImGui::GetStyle().FramePadding.x});
    }
};

/// Returns whether its tooltip is shown.
bool draw_bar_button(const BarButton& button, float side, std::vector<WindowCommand>& asked) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const ImVec4* const colours = ImGui::GetStyle().Colors;
    if (button.is_lit) ImGui::PushStyleColor(ImGuiCol_Text, colours[ImGuiCol_SliderGrab]);
    if (ImGui::Button(button.words.c_str(), ImVec2(button.wide(side), side))) asked.push_back(button.command);
    if (button.is_lit) ImGui::PopStyleColor();
    draw_sign(button.sign, at, side, ImGui::GetColorU32(ImGuiCol_Text));
    const bool is_explained = explain_button(button.what);
    ImGui::SameLine();
    return is_explained;
}

BarButton play_button(const PanelFacts& facts) {
    const bool plays = facts.playing && !facts.at_end;
    return {.words = "##play",
            .what = "play or pause (Space)",
            .need = Need::always,
            .command = {WindowVerb::play_pause},
            .sign = plays ? ButtonSign::pause : ButtonSign::play};
}

/// The buttons right of the seek bar.
std::vector<BarButton> buttons_of(const PanelFacts& facts, float scale, bool panel_shown, bool help_shown) {
    std::vector<BarButton> buttons{{.words = formatted("%g\xC3\x97##speed", facts.speed),
                                    .what = "how fast the clip plays ([ ])",
                                    .need = Need::speed,
                                    .command = {WindowVerb::speed, facts.speed >= 4 ? 0.25 : facts.speed * 2},
                                    .width = 46 * scale},
                                   {.words = "loop",
                                    .what = "loop on or off (L)",
                                    .need = Need::loop,
                                    .command = {WindowVerb::loop},
                                    .is_lit = facts.looping},
                                   {.words = facts.overlay + "##overlay",
                                    .what = "colour the surface by depth, stiffness, ... (O)",
                                    .need = Need::colours,
                                    .command = {WindowVerb::overlay},
                                    .width = 132 * scale}};
    if (!facts.hand)  // with a device, dragging always turns
        buttons.push_back({.words = "turn",
                           .what = "dragging turns the view; again: presses (V)",
                           .need = Need::turn,
                           .command = {WindowVerb::turning},
                           .is_lit = facts.is_turning});
    buttons.insert(buttons.end(), {{.words = "##home",
                                    .what = "back to the clip's own view (Home)",
                                    .need = Need::home,
                                    .command = {WindowVerb::home},
                                    .sign = ButtonSign::home},
                                   {.words = "measure",
                                    .what = "measure between two places: click both (T)",
                                    .need = Need::measure,
                                    .command = {WindowVerb::measure},
                                    .is_lit = facts.measure.is_held},
                                   {.words = "settings",
                                    .what = "fingers, filters, colours and how it goes (Tab)",
                                    .need = Need::settings,
                                    .command = {WindowVerb::panel},
                                    .is_lit = panel_shown},
                                   {.words = "?",
                                    .what = "all keys",
                                    .need = Need::always,
                                    .command = {WindowVerb::help},
                                    .is_lit = help_shown}});
    return buttons;
}

/// The buttons left of the seek bar, beside play.
std::vector<BarButton> buttons_of_list(const PanelFacts& facts) {
    if (facts.clips < 2) return {};
    return {{.words = "##previous",
             .what = "previous clip (PageUp)",
             .need = Need::other_clip,
             .command = {WindowVerb::previous},
             .sign = ButtonSign::previous},
            {.words = "##next",
             .what = "next clip (PageDown)",
             .need = Need::other_clip,
             .command = {WindowVerb::next},
             .sign = ButtonSign::next}};
}

/// The clip's position as text.
struct TimeWords {
    std::string words;
    float width = 0;  ///< enough while playing and while paused, with any digits
};

TimeWords time_words(const PanelFacts& facts, bool has_room) {
    const std::string now = clock_words(facts.seconds);
    if (!has_room) return {now, wide_digits(now)};
    const std::string frame = now + " frame " + std::to_string(facts.frame),
                      end = facts.clip_seconds > 0 ? now + " / " + clock_words(facts.clip_seconds) : now;
    const bool plays = facts.playing && !facts.at_end;
    return {plays ? end : frame, std::max(wide_digits(frame), wide_digits(end))};
}

float bar_width(const std::vector<BarButton>& buttons, float side) {
    float wide = 0;
    for (const BarButton& button : buttons) wide += button.wide(side) + ImGui::GetStyle().ItemSpacing.x;
    return wide;
}

}  // namespace

/// Call once a picture.
void WindowPanel::lead_keys(bool into_a_list) {
    ImGui::GetIO().ConfigFlags = into_a_list ? ImGuiConfigFlags_NavEnableKeyboard : 0;
    if (has_keys_ && !into_a_list) ImGui::SetWindowFocus(nullptr);
    has_keys_ = into_a_list;
}

bool WindowPanel::takes_key(const InputEvent& event) const {
    const auto keys = {"up", "down", "left", "right", "space", "enter"};
    return has_keys_ && !event.control && std::ranges::find(keys, event.word) != keys.end();
}

bool WindowPanel::holds_pointer() const {
    return ImGui::IsAnyItemActive();
}

void WindowPanel::draw(const PanelFacts& facts, int width, int height, std::vector<WindowCommand>& asked) {
    const auto w = static_cast<float>(width), h = static_cast<float>(height);
    const float m = panel_margin * scale_, bar = panel_bar_height * scale_;
    boxes_.clear();
    lead_keys(menu_at || !facts.files.rows.empty() || (has_focus && shown && !help_shown && !hidden));
    draw_brush_line(facts.brush, scale_);
    draw_measured_line(facts.measure, scale_);
    draw_finger_halos(facts.halos, scale_);
    const bool is_stopped = !facts.force_on && !facts.hand;
    words_bottom_ = 0;
    if (hidden && silent && !facts.kiosk) return;
    if (is_stopped && !facts.kiosk && !help_shown) draw_stop(w, h);
    if (hidden && !facts.kiosk && !menu_at && facts.files.rows.empty()) {
        draw_fault(facts, w, h, asked);
        return draw_message(facts, w, h);
    }
    const bool has_page = facts.study && facts.study->is_page;
    if (!help_shown && !has_page) draw_state(facts, w);  // the help shows the state
    if (facts.study) {
        if (facts.study->shows_force && !has_page) draw_force(facts, h, scale_);
        begin_study(*facts.study, w, h, asked);
        note_box();
        ImGui::End();
        if (!has_page && facts.kiosk->is_turned) draw_turn_back(facts.kiosk->texts.turn_back, w, asked);
        return;
    }
    if (facts.kiosk) return draw_kiosk(facts, w, h, asked);
    if (wants_bar(facts)) {
        bar_.draw(facts, w, h, scale_, shown, help_shown, asked);
        bar_box_ = note_box();
        ImGui::End();
    }
    draw_fault(facts, w, h, asked);
    if (!help_shown || facts.message_is_bad) draw_message(facts, w, h);
    if (draw_page(facts, m, w, h, asked)) return;  // it needs the room
    draw_force(facts, h, scale_);
    draw_place(facts, w, h, scale_);
    if (facts.scale && (!shown || is_roomy(w))) {
        const float right = w - m - (shown ? side_width(w) + m : 0), bottom = h - 2 * m - bar,
                    beside_place = right - w / 2 - 2 * m;
        const float explained = wants_bar(facts) && bar_.explains() ? explanation_height() : 0;
        draw_overlay_scale(*facts.scale, right, bottom - explained,
                           right > 580 * scale_ ? widest_scale * scale_ : beside_place, scale_);
    }
    if (shown) draw_side(facts, w, h, asked);
    if (menu_at) draw_menu(facts, w, h, asked);
}

/// What can be done, with keys; a choice, or a click beside it, closes it.
void WindowPanel::draw_menu(const PanelFacts& facts, float width, float height,
                            std::vector<WindowCommand>& asked) {
    const std::tuple<const char*, WindowCommand, bool> rows[] = {
        {"copy the values here", {WindowVerb::copy}, true},
        {"measure from here", {WindowVerb::measure, 0, "here"}, true},
        {"make this the view's middle", {WindowVerb::centre}, true},
        {"the view before", {WindowVerb::undo_view}, facts.can_undo_view},
        {"the clip's own view", {WindowVerb::home}, true},
        {"next colours", {WindowVerb::overlay}, true},
        {"hide bars and words", {WindowVerb::hide}, true},
        {"full screen", {WindowVerb::fullscreen}, true},
        {"save a picture of the window", {WindowVerb::screenshot}, true},
        {"open a file", {WindowVerb::choose}, true}};
    const float m = panel_margin * scale_, x = static_cast<float>(menu_at->x),
                tall = ImGui::GetTextLineHeightWithSpacing() * std::size(rows) + 2 * m;
    ImGui::SetNextWindowBgAlpha(0.95F);
    begin_box("menu", {.x = x,
                       .y = std::max(std::min(static_cast<float>(menu_at->y), height - m - tall), m),
                       .pivot_x = x + 19 * ImGui::GetFontSize() > width ? x / width : 0,
                       .has_keys = true});
    note_box();
    const std::size_t before = asked.size();
    for (const auto& [words, command, may] : rows)
        if (ImGui::MenuItem(words, keys_of(command.verb).c_str(), false, may)) asked.push_back(command);
    const bool is_beside = ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !ImGui::IsWindowHovered();
    if (asked.size() > before || is_beside) menu_at.reset();
    ImGui::End();
}

float WindowPanel::aside(float width) const {
    return shown && !hidden && !help_shown && is_roomy(width) ? side_width(width) + 2 * panel_margin * scale_
                                                              : 0;
}

void WindowPanel::draw_without_clip(const PanelFacts& facts, int width, int height,
                                    std::vector<WindowCommand>& asked) {
    const auto w = static_cast<float>(width), h = static_cast<float>(height);
    boxes_.clear();
    words_bottom_ = 0;
    lead_keys(!facts.files.rows.empty());
    float top = panel_margin * scale_;
    if (facts.is_empty && facts.files.folder.empty() && !help_shown) {
        top = draw_empty_page(facts.files.rows.size(), w, h, scale_);
        if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !ImGui::GetIO().WantCaptureMouse)
            asked.push_back({WindowVerb::choose});
    }
    draw_fault(facts, w, h, asked);
    draw_message(facts, w, h);
    draw_page(facts, top, w, h, asked);
}

/// The help, or the files to choose from; returns whether it was shown.
bool WindowPanel::draw_page(const PanelFacts& facts, float top, float width, float height,
                            std::vector<WindowCommand>& asked) {
    if (menu_at || (!help_shown && facts.files.rows.empty())) return false;
    const float bottom = height - (facts.is_empty ? 1 : 2) * panel_margin * scale_ -
                         (facts.is_empty ? 0 : panel_bar_height * scale_);
    help_shown ? begin_help(facts, width, height, scale_)
               : begin_files(facts.files, top, width, bottom, scale_, asked);
    note_box();
    ImGui::End();
    return true;
}

WindowPanel::Box WindowPanel::note_box() {
    const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    return boxes_.emplace_back(Box{at.x, at.y, at.x + size.x, at.y + size.y});
}

WindowPanel::Free WindowPanel::free_of(const PanelFacts& facts, float width) const {
    const bool has_clip = !facts.clip.empty(), is_beside = shown && has_clip;
    const float m = panel_margin * scale_,
                from = facts.hand || (has_clip && (shown || !is_roomy(width))) ? 104 * scale_ : 0.0F,
                to = is_beside ? width - side_width(width) - 2 * m : width, room = to - from - m;
    return {(from + to) / 2, words_bottom_ > 0 ? words_bottom_ + m / 2 : m, room,
            (is_roomy(width) && !is_beside ? std::min(room, width * 0.6F) : room) - m};
}

/// Draws the state of forces, always visible.
void WindowPanel::draw_state(const PanelFacts& facts, float width) {
    if (!facts.hand) return;
    const HandState& state = facts.hand->state;
    const Free free = free_of(facts, width);
    begin_box("state",
              {.x = free.middle, .y = free.top, .pivot_x = 0.5F, .flags = ImGuiWindowFlags_NoInputs});
    ImGui::PushTextWrapPos(free.width);
    using What = HandState::What;
    const ImVec4 on(0.55F, 0.90F, 0.55F, 1), off(0.95F, 0.78F, 0.35F, 1);
    const ImVec4& colour = state.what == What::on ? on : (state.what == What::away ? bad_words : off);
    ImGui::TextColored(colour, "%s", state.words.c_str());
    if (!state.remark.empty()) ImGui::TextUnformatted(state.remark.c_str());
    ImGui::PopTextWrapPos();
    words_bottom_ = ImGui::GetWindowPos().y + ImGui::GetWindowHeight();
    ImGui::End();
}

/// Draws a fault, until it is dismissed or its time is over.
void WindowPanel::draw_fault(const PanelFacts& facts, float width, float height,
                             std::vector<WindowCommand>& asked) {
    if (facts.faults.empty()) return;
    const Free free = free_of(facts, width);
    // At most down to the bar.
    const float room = height - free.top - (2 * panel_margin + panel_bar_height) * scale_;
    ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(width, std::max(room, 30 * scale_)));
    begin_box("fault", {.x = free.middle, .y = free.top, .pivot_x = 0.5F, .scrolls = true});
    note_box();
    ImGui::PushTextWrapPos(free.wrap);
    ImGui::TextColored(bad_words, "%s", facts.faults.front().c_str());
    const std::size_t more = facts.faults.size() - 1;
    ImGui::TextDisabled("click, or Escape: read%s",
                        more > 0 ? ("; " + std::to_string(more) + " more").c_str() : "");
    ImGui::PopTextWrapPos();
    if (ImGui::IsWindowHovered() && ImGui::IsMouseClicked(ImGuiMouseButton_Left))
        asked.push_back({WindowVerb::dismiss});
    words_bottom_ = ImGui::GetWindowPos().y + ImGui::GetWindowHeight();
    ImGui::End();
}

/// Draws a message above the middle of the panel's free space; not on the bar, but where a long fault is.
void WindowPanel::draw_message(const PanelFacts& facts, float width, float height) {
    if (facts.message.empty()) return;
    const Free free = free_of(facts, width);
    // Sets the size, as ImGui's own is that of the previous text.
    const ImVec2 padding = ImGui::GetStyle().WindowPadding;
    const ImVec2 words = ImGui::CalcTextSize(facts.message.c_str(), nullptr, false, free.wrap - padding.x);
    const ImVec2 size(words.x + 2 * padding.x, words.y + 2 * padding.y);
    const float lowest = height - (2 * panel_margin + panel_bar_height) * scale_ - size.y;
    ImGui::SetNextWindowSize(size);
    begin_box("message", {.x = free.middle,
                          .y = std::min(free.top, std::max(lowest, panel_margin * scale_)),
                          .pivot_x = 0.5F,
                          .flags = ImGuiWindowFlags_NoInputs});
    ImGui::PushTextWrapPos(free.wrap);
    ImGui::TextColored(facts.message_is_bad ? bad_words : ImGui::GetStyle().Colors[ImGuiCol_Text], "%s",
                       facts.message.c_str());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

void PlaybackBar::draw(const PanelFacts& facts, float width, float height, float scale, bool panel_shown,
                       bool help_shown, std::vector<WindowCommand>& asked) {
    const float m = panel_margin * scale, side = 30 * scale, least_seek = 90 * scale;
    begin_box(
        "playback",
        {.x = m, .y = height - m, .pivot_y = 1, .width = width - 2 * m, .height = panel_bar_height * scale});
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(8 * scale, (side - ImGui::GetFontSize()) / 2));
    const TimeWords time = time_words(facts, width > 520 * scale);
    std::vector<BarButton> left = buttons_of_list(facts),
                           right = buttons_of(facts, scale, panel_shown, help_shown);
    const auto room = [&] {
        const float gap = ImGui::GetStyle().ItemSpacing.x;
        return ImGui::GetContentRegionAvail().x - bar_width(left, side) - bar_width(right, side) -
               (side + gap) - (time.width + gap);
    };
    for (Need need = Need::colours; need != Need::always && room() < least_seek;
         need = static_cast<Need>(static_cast<int>(need) + 1))
        for (auto* const buttons : {&left, &right})
            std::erase_if(*buttons, [need](const BarButton& button) { return button.need == need; });
    const float seek = room();
    explains_ = false;
    const auto draw_one = [&](const BarButton& button) {
        explains_ = draw_bar_button(button, side, asked) || explains_;
    };
    if (!left.empty()) draw_one(left.front());
    if (!facts.is_live) draw_one(play_button(facts));  // a live source takes no commands to its clock
    if (!left.empty()) draw_one(left.back());
    ImGui::AlignTextToFramePadding();
    const float time_left = ImGui::GetCursorPosX();
    ImGui::TextUnformatted(time.words.c_str());
    ImGui::SameLine(time_left + time.width + ImGui::GetStyle().ItemSpacing.x);
    draw_seek(facts, scale, seek, asked);
    ImGui::SameLine();
    for (const BarButton& button : right) draw_one(button);
    ImGui::PopStyleVar();
}

/// The seek bar, with a mark at each sudden change of the picture's depth.
void PlaybackBar::draw_seek(const PanelFacts& facts, float scale, float room,
                            std::vector<WindowCommand>& asked) {
    const float wide = std::max(60 * scale, room);
    ImGui::SetNextItemWidth(wide);
    const ImVec2 at_left = ImGui::GetCursorScreenPos();
    float at = dragging_ ? dragged_seconds_ : static_cast<float>(facts.seconds);
    // At the last frame the handle is at the end; a still has only that frame.
    const auto end = static_cast<float>(std::max(facts.last_seconds, 0.001));
    if (!dragging_ && facts.at_end) at = end;
    if (ImGui::SliderFloat("##seek", &at, 0, end, "", ImGuiSliderFlags_NoInput)) {
        dragged_seconds_ = at;
        asked.push_back({WindowVerb::seek_to, static_cast<double>(std::clamp(at, 0.0F, end))});
    }
    dragging_ = ImGui::IsItemActive();
    const float grab = ImGui::GetStyle().GrabMinSize / 2 + 2, tall = ImGui::GetItemRectSize().y;
    if (ImGui::IsItemHovered()) {
        const float share = (ImGui::GetMousePos().x - at_left.x - grab) / (wide - 2 * grab);
        explains_ = true;
        ImGui::SetTooltip("%s",
                          clock_words(static_cast<double>(std::clamp(share, 0.0F, 1.0F) * end)).c_str());
    }
    for (const double cut : facts.cuts) {
        if (cut > end) continue;  // streams have no end
        const float x = at_left.x + grab + (wide - 2 * grab) * static_cast<float>(cut) / end;
        ImGui::GetWindowDrawList()->AddLine(ImVec2(x, at_left.y + tall * 0.68F), ImVec2(x, at_left.y + tall),
                                            IM_COL32(255, 200, 110, 230), 2 * scale);
    }
}

}  // namespace touchable
