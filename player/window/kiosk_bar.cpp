#include "player/window/kiosk_bar.hpp"

#include <algorithm>

#include "player/window/corner_panels.hpp"
#include "player/window/panel_rows.hpp"

namespace touchable {
namespace {

constexpr float least_high = 60, most_high = 110, share_of_height = 0.1F;  // of a button
constexpr float smallest_words = 11;
constexpr ImU32 bar_ground = IM_COL32(10, 13, 18, 110), button_ground = IM_COL32(28, 33, 42, 225),
                button_under = IM_COL32(58, 67, 83, 240), button_pressed = IM_COL32(87, 181, 232, 255),
                button_ink = IM_COL32(240, 243, 247, 255), button_lit = IM_COL32(110, 197, 243, 255),
                button_dim = IM_COL32(128, 136, 150, 255), button_dark = IM_COL32(10, 14, 20, 255);

float width_of(const std::string& words, float size) {
    return font_of_size(size)->CalcTextSizeA(size, 1e6F, 0, words.c_str()).x;
}

}  // namespace

/// Whatever there is nothing to do by is left out: a still does not pause, and a held device turns nothing.
std::vector<KioskBar::Button> KioskBar::buttons_of(const PanelFacts& facts) {
    const KioskTexts& texts = facts.kiosk->texts;
    const bool turns = facts.is_turning,
               plays = facts.playing;  // also at the end: it begins anew, or the next comes
    std::vector<Button> buttons;
    if (!facts.hand)  // there dragging always turns
        buttons.push_back({.id = "mode",
                           .words = turns ? texts.touch : texts.turn,
                           .sign = turns ? ButtonSign::touch : ButtonSign::turn,
                           .command = {WindowVerb::turning},
                           .is_lit = turns,
                           .or_words = turns ? texts.turn : texts.touch});
    if (!facts.kiosk->is_still)
        buttons.push_back({.id = "pause",
                           .words = plays ? texts.pause : texts.play,
                           .sign = plays ? ButtonSign::pause : ButtonSign::play,
                           .command = {WindowVerb::play_pause},
                           .is_lit = !plays,
                           .or_words = plays ? texts.play : texts.pause});
    buttons.push_back({.id = "colours",
                       .words = texts.colours,
                       .sign = ButtonSign::colours,
                       .command = {WindowVerb::overlay},
                       .is_lit = facts.scale != nullptr,
                       .or_words = texts.colours});
    if (facts.clips > 1)
        buttons.push_back({.id = "next",
                           .words = texts.next,
                           .sign = ButtonSign::next,
                           .command = {WindowVerb::next},
                           .or_words = texts.next});
    buttons.push_back({.id = "straight",
                       .words = texts.turn_back,
                       .sign = ButtonSign::home,
                       .command = {WindowVerb::home},
                       .is_there = facts.kiosk->is_turned,
                       .or_words = texts.turn_back});
    return buttons;
}

/// As wide as the longest words want; where that is too wide they are smaller, and where they would be too
/// small to read there are signs alone.
KioskBar::KioskBar(const PanelFacts& facts, float width, float height, float scale)
    : buttons_(buttons_of(facts)),
      bottom_(height - panel_margin * scale / 2),
      high_(std::clamp(share_of_height * height, least_high * scale, most_high * scale)),
      text_(0.25F * high_),
      gap_(6 * scale) {
    const auto count = static_cast<float>(buttons_.size());
    float longest = 0;
    for (const Button& button : buttons_)
        longest = std::max({longest, width_of(button.words, text_), width_of(button.or_words, text_)});
    const float room = (width - 2 * gap_ - (count + 1) * gap_) / count;
    wide_ = std::min(std::max(1.4F * high_, longest + text_), room);
    text_ *= std::min(1.0F, (wide_ - 0.4F * text_) / longest);
    if (text_ < smallest_words * scale) text_ = 0;
    const float all = count * wide_ + (count + 1) * gap_;
    left_ = (width - all) / 2;
    right_ = left_ + all;
    top_ = bottom_ - high_ - 2 * gap_;
}

void KioskBar::draw_button(const Button& button, const ImVec2& at, std::vector<WindowCommand>& asked) const {
    ImGui::SetCursorScreenPos(at);
    if (ImGui::InvisibleButton(button.id, ImVec2(wide_, high_)) && button.is_there)
        asked.push_back(button.command);
    const bool is_pressed = button.is_there && ImGui::IsItemActive(),
               is_under = button.is_there && ImGui::IsItemHovered();
    const ImU32 ground = is_pressed ? button_pressed : (is_under ? button_under : button_ground);
    const ImU32 ink = is_pressed         ? button_dark
                      : !button.is_there ? button_dim
                      : button.is_lit    ? button_lit
                                         : button_ink;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImVec2 end(at.x + wide_, at.y + high_);
    list.AddRectFilled(at, end, ground, 1.5F * gap_);
    if (button.is_lit) list.AddRect(at, end, button_lit, 1.5F * gap_, 0, gap_ / 3);
    const float sign = text_ > 0 ? 0.68F * high_ : std::min(high_, wide_);
    const float top = text_ > 0 ? at.y + 0.02F * high_ : at.y + (high_ - sign) / 2;
    draw_sign(button.sign, ImVec2(at.x + (wide_ - sign) / 2, top), sign, ink);
    if (text_ == 0) return;
    const float x = at.x + (wide_ - width_of(button.words, text_)) / 2;
    list.AddText(font_of_size(text_), text_, ImVec2(x, end.y - 0.1F * high_ - text_), ink,
                 button.words.c_str());
}

void KioskBar::draw(std::vector<WindowCommand>& asked) const {
    ImGui::SetNextWindowPos(ImVec2(left_, top_));
    ImGui::SetNextWindowSize(ImVec2(right_ - left_, bottom_ - top_));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));  // beyond which nothing is drawn
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
    ImGui::Begin("kiosk", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing |
                     ImGuiWindowFlags_NoBackground);
    ImGui::PopStyleVar(2);
    ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(left_, top_), ImVec2(right_, bottom_), bar_ground,
                                              2.2F * gap_);
    float x = left_ + gap_;
    for (const Button& button : buttons_) {
        draw_button(button, ImVec2(x, top_ + gap_), asked);
        x += wide_ + gap_;
    }
    ImGui::End();
}

}  // namespace touchable
