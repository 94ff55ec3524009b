#include "player/window/window_panel.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "engine/base/number_words.hpp"
#include "player/window/corner_panels.hpp"
#include "player/window/empty_page.hpp"
#include "player/window/help_page.hpp"
#include "player/window/invitation.hpp"
#include "player/window/kiosk_bar.hpp"
#include "player/window/measure_panel.hpp"
#include "player/window/panel_rows.hpp"
#include "player/window/pixel_words.hpp"

namespace touchable {
namespace {

const ImVec4 bad_words(1.0F, 0.62F, 0.45F, 1);

}  // namespace

WindowPanel::Box WindowPanel::note_box() {
    const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    return boxes_.emplace_back(Box{at.x, at.y, at.x + size.x, at.y + size.y});
}

/// Beside what is set in the panel; and at the end, where it is what goes on.
bool WindowPanel::wants_bar(const PanelFacts& facts) const {
    return bar_shown || shown || help_shown || (facts.at_end && facts.last_seconds > 0);
}

bool WindowPanel::covers(double x, double y) const {
    return std::any_of(boxes_.begin(), boxes_.end(), [x, y](const Box& box) { return box.has(x, y); });
}

void WindowPanel::remember(const PanelFacts& facts, double frame_ms, double tick_us) {
    curves_.remember({facts.forces, frame_ms, tick_us, facts.late_ticks, facts.dropped_frames});
}

void WindowPanel::draw(const PanelFacts& facts, int width, int height, std::vector<WindowCommand>& asked) {
    const auto w = static_cast<float>(width), h = static_cast<float>(height);
    const float m = panel_margin * scale_, bar = panel_bar_height * scale_;
    boxes_.clear();
    draw_brush_line(facts.brush, scale_);
    draw_measured_line(facts.measure, scale_);
    draw_finger_halos(facts.halos, scale_);
    const bool is_stopped = !facts.force_on && !facts.hand;
    if (is_stopped && !facts.kiosk && !help_shown) draw_stop(w, h);
    words_bottom_ = 0;
    const bool has_page = facts.study && facts.study->is_page;
    if (!help_shown && !has_page) draw_state(facts, w);  // it is among the help
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
    draw_fault(facts, w, asked);
    if (!help_shown || facts.message_is_bad) draw_message(facts, w);
    if (help_shown) {
        begin_help(facts, w, h, scale_);  // which needs the room
        note_box();
        return ImGui::End();
    }
    draw_force(facts, h, scale_);
    const float above_place = draw_place(facts, w, h, scale_);
    if (facts.scale && (!shown || is_roomy(w))) {
        const float right = w - m - (shown ? side_width(w) + m : 0);
        const bool is_beside = right > 580 * scale_;  // what is said of the place
        const float bottom = is_beside ? h - 2 * m - bar : above_place;
        const float explained = wants_bar(facts) && bar_.explains() ? explanation_height() : 0;
        draw_overlay_scale(*facts.scale, right, bottom - explained, scale_);
    }
    if (shown) draw_side(facts, w, h, asked);
}

/// What is written leaves the bar its place, shown or not: nothing moves when it comes and goes.
void WindowPanel::draw_kiosk(const PanelFacts& facts, float width, float height,
                             std::vector<WindowCommand>& asked) {
    const KioskFacts& kiosk = *facts.kiosk;
    const bool is_stopped = !facts.force_on && !facts.hand;
    const KioskBar bar(facts, width, height, scale_);
    const float above = kiosk.has_bar ? bar.top() : height;
    const bool has_words = draw_kiosk_words(kiosk, is_stopped, width, height, above);
    bar_box_ = kiosk.has_bar ? Box{bar.left(), bar.top(), bar.right(), bar.bottom()} : Box{};
    if (kiosk.invited_s) return;
    draw_force(facts, height, scale_);
    constexpr float widest_scale = 330;
    const float right = width - panel_margin * scale_;
    const bool is_beside = !kiosk.has_bar || right - widest_scale * scale_ > bar.right();
    if (kiosk.scale && !has_words)
        draw_overlay_scale(*kiosk.scale, right, (is_beside ? height : above) - panel_margin * scale_, scale_);
    if (!kiosk.has_bar && kiosk.is_turned) draw_turn_back(kiosk.texts.turn_back, width, asked);
    if (!kiosk.has_bar || !bar_shown) return;
    bar.draw(asked);
    boxes_.push_back(bar_box_);
}

/// For visitors who have no keys, and participants of a study.
void WindowPanel::draw_turn_back(const std::string& words, float width, std::vector<WindowCommand>& asked) {
    const float m = panel_margin * scale_;
    begin_box("turn back", {.x = width - m, .y = m, .pivot_x = 1});
    note_box();
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(12 * scale_, 10 * scale_));
    if (ImGui::Button((words + "##turn back").c_str())) asked.push_back({WindowVerb::home});
    ImGui::PopStyleVar();
    ImGui::End();
}

void WindowPanel::draw_without_clip(const PanelFacts& facts, int width, int height,
                                    std::vector<WindowCommand>& asked) {
    const auto w = static_cast<float>(width);
    boxes_.clear();
    words_bottom_ = 0;
    const auto h = static_cast<float>(height);
    if (facts.is_empty && !help_shown) draw_empty_page(w, h, scale_);
    draw_fault(facts, w, asked);
    draw_message(facts, w);
    if (!help_shown) return;
    begin_help(facts, w, h, scale_);
    note_box();
    ImGui::End();
}

void WindowPanel::draw_pointer(const PanelFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    draw_label("fingers", scale);
    const std::vector<const char*> counts{"1", "2", "3", "4", "5"};
    const int count = draw_words("fingers", counts, static_cast<int>(facts.forces.size()) - 1, true);
    if (count >= 0) asked.push_back({WindowVerb::fingers, static_cast<double>(count + 1)});
    explain_row("How many fingers there are round the pointer.");
    draw_label("depth, mm", scale);
    auto depth = static_cast<float>(facts.pressed_mm);
    const std::string depth_words = pressed_in_words(facts.pressed_mm);
    if (draw_slider("##depth", depth, -6, 12, depth_words, scale))
        asked.push_back({WindowVerb::deeper, static_cast<double>(depth) - facts.pressed_mm});
    explain_row(
        "How deep a finger is meant to be in the surface, or how far above it, millimetres of the hand. So "
        "does the wheel.");
}

void WindowPanel::draw_hand(const HandFacts& hand, float scale) {
    draw_label("device", scale);
    ImGui::TextUnformatted(hand.device.c_str());
    explain_row("What leads the fingers. C, held down, repositions the hand; R puts its middle where it is.");
    draw_label("forces", scale);
    ImGui::TextUnformatted(hand.state.mood == HandState::Mood::on    ? "on"
                           : hand.state.mood == HandState::Mood::off ? "off"
                                                                     : "off: it is away");
    explain_row("Whether the hand feels what the fingers meet. F asks for it, and stops it.");
    draw_label("position", scale);
    if (std::isfinite(hand.age_s))
        ImGui::Text("%.1f ms old", 1000 * hand.age_s);
    else
        ImGui::TextUnformatted("none");
    explain_row("How long ago the device said where the hand is. What is older than 20 ms counts as none.");
    draw_label("scale", scale);
    ImGui::Text("1 m is %.3g m", hand.scene_per_metre);
    explain_row("How far a finger goes in the scene for 1 m of the hand. J: finer; K: coarser.");
}

/// For whoever has neither a middle button nor keys.
void WindowPanel::draw_view(float scale, std::vector<WindowCommand>& asked) {
    draw_label("view", scale);
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x / 2, side = ImGui::GetFrameHeight();
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
    explain_row(
        "Turns the view, nearer, farther. So do Ctrl and the arrows, + and -, or dragging with Ctrl held.");
}

/// What the finger and the clip do now.
void WindowPanel::draw_finger(const PanelFacts& facts, float scale, std::vector<WindowCommand>& asked) {
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
    draw_label("volume", scale);
    auto volume = static_cast<float>(facts.volume);
    if (draw_slider("##volume", volume, 0, 100, formatted("%d %%", facts.volume), scale))
        asked.push_back({WindowVerb::volume, static_cast<double>(volume)});
    explain_row("How loud the clip and what is touched are. So do 9 and 0; M: silence.");
    draw_label("colours", scale);
    if (ImGui::Button((facts.overlay + "##colours").c_str(), ImVec2(-1, 0)))
        asked.push_back({WindowVerb::overlay});
    explain_row("What the surface is coloured by. A click, or O: the next.");
    draw_label("dents", scale);
    const int dents = draw_words("dents", {"off", "on"}, facts.is_dented ? 1 : 0, true);
    if (dents >= 0) asked.push_back({WindowVerb::dent, static_cast<double>(dents)});
    explain_row(
        "Whether you see the surface give way under a finger, and stretch where it sticks. It changes no "
        "force.");
    draw_view(scale, asked);
    draw_measure(facts.measure, scale, asked);
    const float half = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    if (ImGui::Button(facts.force_on ? "force off" : "force on", ImVec2(half, 0)))
        asked.push_back({WindowVerb::force});
    ImGui::SameLine();
    if (ImGui::Button("clip's own view", ImVec2(-1, 0))) asked.push_back({WindowVerb::home});
}

/// The clip's name, as far as there is room, and what forgets all settings.
void WindowPanel::draw_title(const PanelFacts& facts, float scale, std::vector<WindowCommand>& asked) {
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

void WindowPanel::draw_side(const PanelFacts& facts, float width, float height,
                            std::vector<WindowCommand>& asked) {
    const bool roomy = is_roomy(width), tall = height > 600 * scale_;
    const float m = panel_margin * scale_, scale = roomy ? scale_ : 0.86F * scale_;
    ImGui::SetNextWindowPos(ImVec2(width - m, m), ImGuiCond_Always, ImVec2(1, 0));
    ImGui::SetNextWindowSize(ImVec2(side_width(width), height - 3 * m - panel_bar_height * scale_));
    // The picture behind it is what the settings are about.
    if (!roomy) ImGui::SetNextWindowBgAlpha(0.7F);
    // What does not fit is scrolled to.
    ImGui::Begin("panel", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav);
    note_box();
    ImGui::SetWindowFontScale(scale / scale_);
    const ImGuiStyle& style = ImGui::GetStyle();
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(style.FramePadding.x, 2 * scale));
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(style.ItemSpacing.x, 4 * scale));
    draw_title(facts, scale, asked);
    draw_finger(facts, scale, asked);
    // Whoever takes a tool wants to see what else there is.
    const bool is_held = facts.brush.tool != BrushTool::touch;
    if (std::exchange(tool_was_held_, is_held) != is_held) ImGui::SetNextItemOpen(is_held);
    if (draw_fold("Materials", false)) draw_materials(facts.brush, scale, asked);
    if (draw_fold("What is felt", true)) settings_.draw(facts.settings, scale, asked);
    if (draw_fold("Filters of depth", tall)) settings_.draw_filters(facts.settings, scale, asked);
    if (draw_fold("Relief of colour", tall)) settings_.draw_relief(facts.settings, scale, asked);
    if (draw_fold("How it goes", tall)) {
        curves_.draw(facts.limit_newtons, scale);
        for (const std::string& line : facts.figures) draw_remark(line);
    }
    ImGui::PopStyleVar(2);
    ImGui::End();
}

WindowPanel::Free WindowPanel::free_of(const PanelFacts& facts, float width) const {
    const bool is_narrow = width < 480 * scale_ && !facts.is_empty;  // where no force is shown
    return {shown || facts.hand || is_narrow ? 104 * scale_ : 0.0F,
            shown ? width - side_width(width) - 2 * panel_margin * scale_ : width};
}

/// Whether forces are on: always to be read, whatever else is shown.
void WindowPanel::draw_state(const PanelFacts& facts, float width) {
    if (!facts.hand) return;
    const HandState& state = facts.hand->state;
    const auto [from, to] = free_of(facts, width);
    const float m = panel_margin * scale_;
    begin_box("state", {.x = (from + to) / 2, .y = m, .pivot_x = 0.5F, .flags = ImGuiWindowFlags_NoInputs});
    ImGui::PushTextWrapPos(to - from - m);
    using Mood = HandState::Mood;
    const ImVec4 on(0.55F, 0.90F, 0.55F, 1), off(0.95F, 0.78F, 0.35F, 1);
    const ImVec4& colour = state.mood == Mood::on ? on : (state.mood == Mood::off ? off : bad_words);
    ImGui::TextColored(colour, "%s", state.words.c_str());
    if (!state.remark.empty()) ImGui::TextUnformatted(state.remark.c_str());
    ImGui::PopTextWrapPos();
    words_bottom_ = ImGui::GetWindowPos().y + ImGui::GetWindowHeight();
    ImGui::End();
}

/// What went wrong, until somebody has read it.
void WindowPanel::draw_fault(const PanelFacts& facts, float width, std::vector<WindowCommand>& asked) {
    if (facts.faults.empty()) return;
    const auto [from, to] = free_of(facts, width);
    const float m = panel_margin * scale_, top = words_bottom_ > 0 ? words_bottom_ + m / 2 : m;
    begin_box("fault", {.x = (from + to) / 2, .y = top, .pivot_x = 0.5F});
    note_box();
    ImGui::PushTextWrapPos(std::min(to - from - m, shown ? to : width * 0.6F));
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

/// Above the middle of what the panel leaves free.
void WindowPanel::draw_message(const PanelFacts& facts, float width) {
    if (facts.message.empty()) return;
    const auto [from, to] = free_of(facts, width);
    const float m = panel_margin * scale_, top = words_bottom_ > 0 ? words_bottom_ + m / 2 : m;
    const float wrap = std::min(to - from - m, shown ? to : width * 0.6F);
    // By itself a box has the size of the words before.
    const ImVec2 padding = ImGui::GetStyle().WindowPadding;
    const ImVec2 words = ImGui::CalcTextSize(facts.message.c_str(), nullptr, false, wrap - padding.x);
    ImGui::SetNextWindowSize(ImVec2(words.x + 2 * padding.x, words.y + 2 * padding.y));
    begin_box("message",
              {.x = (from + to) / 2, .y = top, .pivot_x = 0.5F, .flags = ImGuiWindowFlags_NoInputs});
    ImGui::PushTextWrapPos(wrap);
    ImGui::TextColored(facts.message_is_bad ? bad_words : ImGui::GetStyle().Colors[ImGuiCol_Text], "%s",
                       facts.message.c_str());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

float WindowPanel::side_width(float width) const {
    return is_roomy(width) ? 310 * scale_ : std::min(250 * scale_, width * 0.4F);
}

}  // namespace touchable
