// SPDX-License-Identifier: Apache-2.0
// A kiosk's visitor interface, a bar of large buttons and large texts; and the pages of a study.

#include <imgui.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "player/window/panel_parts.hpp"
#include "player/window/window_panel.hpp"

namespace touchable {
namespace {

constexpr float least_high = 60, most_high = 110, share_of_height = 0.1F;  // of a button
constexpr float smallest_words = 11;

constexpr ImU32 bar_ground = IM_COL32(10, 13, 18, 110), button_ground = IM_COL32(28, 33, 42, 225),
                button_under = IM_COL32(58, 67, 83, 240), button_pressed = IM_COL32(87, 181, 232, 255),
                button_ink = IM_COL32(240, 243, 247, 255), button_lit = IM_COL32(110, 197, 243, 255),
                button_dim = IM_COL32(128, 136, 150, 255), button_dark = IM_COL32(10, 14, 20, 255);

/// An ImGui window of which nothing is seen but what is drawn in it.
void begin_canvas(const char* name, ImVec2 at, ImVec2 size) {
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));  // drawing is clipped to it
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
    begin_box(
        name,
        {.x = at.x, .y = at.y, .width = size.x, .height = size.y, .flags = ImGuiWindowFlags_NoBackground});
    ImGui::PopStyleVar(3);
}

/// Spacing between lines, in addition to their height.
float pause_between(float size) {
    return 0.35F * size;
}

std::vector<std::string> lines_of(const std::string& words) {
    std::vector<std::string> lines;
    std::istringstream in(words);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

/// Size of its lines, each wrapped at `wrap`; 0: not wrapped.
ImVec2 size_of(const std::string& words, float size, float wrap) {
    ImVec2 all(0, 0);
    for (const std::string& line : lines_of(words)) {
        const ImVec2 one = font_of_size(size)->CalcTextSizeA(size, 1e6F, wrap, line.c_str());
        all = ImVec2(std::max(all.x, one.x), all.y + one.y + (all.y > 0 ? pause_between(size) : 0));
    }
    return all;
}

/// A few large buttons for visitors of a kiosk, sized for fingers, in the middle of the picture's lower edge.
/// Sizes in pixels; `scale` as in ScreenSize.
class KioskBar {
public:
    /// Computes the layout, shown or not; it does not depend on the buttons' current texts. Buttons are as
    /// wide as the longest text; if that is too wide the text shrinks, and below the smallest legible size
    /// there are only signs.
    KioskBar(const PanelFacts& facts, float width, float height, float scale)
        : buttons_(buttons_of(facts)),
          bottom_(height - panel_margin * scale / 2),
          high_(std::clamp(share_of_height * height, least_high * scale, most_high * scale)),
          text_(0.25F * high_),
          gap_(6 * scale) {
        const auto count = static_cast<float>(buttons_.size());
        float longest = 0;
        for (const Button& button : buttons_)
            for (const std::string* const words : {&button.words, button.or_words})
                if (words) longest = std::max(longest, size_of(*words, text_, 0).x);
        const float room = (width - 2 * gap_ - (count + 1) * gap_) / count;
        wide_ = std::min(std::max(1.4F * high_, longest + text_), room);
        text_ *= std::min(1.0F, (wide_ - 0.4F * text_) / longest);
        if (text_ < smallest_words * scale) text_ = 0;
        const float all = count * wide_ + (count + 1) * gap_;
        left_ = (width - all) / 2;
        right_ = left_ + all;
        top_ = bottom_ - high_ - 2 * gap_;
    }
    float left() const { return left_; }
    float top() const { return top_; }
    float right() const { return right_; }
    float bottom() const { return bottom_; }

    /// Call between ImGuiLayer's `begin` and `end`.
    void draw(std::vector<WindowCommand>& asked) const {
        begin_canvas("kiosk", ImVec2(left_, top_), ImVec2(right_ - left_, bottom_ - top_));
        ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(left_, top_), ImVec2(right_, bottom_), bar_ground,
                                                  2.2F * gap_);
        float x = left_ + gap_;
        for (const Button& button : buttons_) {
            draw_button(button, ImVec2(x, top_ + gap_), asked);
            x += wide_ + gap_;
        }
        ImGui::End();
    }

private:
    struct Button {
        const char* id;
        const std::string& words;
        ButtonSign sign;
        WindowCommand command;
        bool is_lit = false;          ///< its switch is on
        bool is_there = true;         ///< false: no effect now
        const std::string* or_words = nullptr;  ///< its text in the other state, if that is another
    };
    /// Leaves out buttons without effect: a still or a camera does not pause, and with a haptic device
    /// dragging always turns.
    static std::vector<Button> buttons_of(const PanelFacts& facts) {
        const KioskTexts& texts = facts.kiosk->texts;
        const bool turns = facts.is_turning,
                   plays = facts.playing;  // also at the end: the clip restarts, or the next one comes
        std::vector<Button> buttons;
        if (!facts.hand)  // with a device, dragging always turns
            buttons.push_back({.id = "mode",
                               .words = turns ? texts.touch : texts.turn,
                               .sign = turns ? ButtonSign::touch : ButtonSign::turn,
                               .command = {WindowVerb::turning},
                               .is_lit = turns,
                               .or_words = turns ? &texts.turn : &texts.touch});
        if (!facts.kiosk->is_still && !facts.is_live)
            buttons.push_back({.id = "pause",
                               .words = plays ? texts.pause : texts.play,
                               .sign = plays ? ButtonSign::pause : ButtonSign::play,
                               .command = {WindowVerb::play_pause},
                               .is_lit = !plays,
                               .or_words = plays ? &texts.play : &texts.pause});
        buttons.push_back({.id = "colours",
                           .words = texts.colours,
                           .sign = ButtonSign::colours,
                           .command = {WindowVerb::overlay},
                           .is_lit = facts.scale != nullptr});
        if (facts.clips > 1)
            buttons.push_back(
                {.id = "next", .words = texts.next, .sign = ButtonSign::next, .command = {WindowVerb::next}});
        buttons.push_back({.id = "straight",
                           .words = texts.turn_back,
                           .sign = ButtonSign::home,
                           .command = {WindowVerb::home},
                           .is_there = facts.kiosk->is_turned});
        return buttons;
    }
    void draw_button(const Button& button, const ImVec2& at, std::vector<WindowCommand>& asked) const {
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
        const float x = at.x + (wide_ - size_of(button.words, text_, 0).x) / 2;
        list.AddText(font_of_size(text_), text_, ImVec2(x, end.y - 0.1F * high_ - text_), ink,
                     button.words.c_str());
    }

    std::vector<Button> buttons_;
    float left_, top_, right_, bottom_;
    float wide_, high_, text_;  // of a button; of its text, 0: no room for text
    float gap_;
};

ImFont& large_font() {
    return *ImGui::GetIO().Fonts->Fonts.back();
}

ImU32 white(float opacity) {
    return IM_COL32(255, 255, 255, static_cast<int>(255 * opacity));
}

ImU32 black(float opacity) {
    return IM_COL32(4, 7, 12, static_cast<int>(255 * opacity));
}

float wide_at(float size, const std::string& words) {
    return large_font().CalcTextSizeA(size, 1e6F, 0, words.c_str()).x;
}

/// Text in the middle of the width, with a soft dark edge to be legible over any picture. Too wide text
/// shrinks, down to a part of its size, and then wraps.
struct CentredWords {
    std::vector<std::string> lines;
    float size;

    CentredWords(const std::string& words, float wanted, float width) : size(wanted) {
        constexpr float smallest = 11, smallest_part = 0.7F;
        const float room = 0.94F * width, wide = wide_at(size, words);
        if (wide > room) size = std::max({smallest, smallest_part * size, size * room / wide});
        constexpr float rounding = 1.01F;  // a line exactly as wide as the room is not wrapped
        const char *from = words.data(), *const end = from + words.size();
        while (from < end) {
            const char* to =
                large_font().CalcWordWrapPositionA(size / large_font().FontSize, from, end, rounding * room);
            if (to == from) ++to;
            lines.emplace_back(from, to);
            for (from = to; from < end && *from == ' ';) ++from;
        }
    }
    /// Additional height beyond one line.
    float more() const { return lines.empty() ? 0 : 1.2F * size * static_cast<float>(lines.size() - 1); }
    void draw(ImDrawList& list, float width, float top, float opacity) const {
        const float shift = std::max(1.0F, size / 28);
        for (const std::string& line : lines) {
            const ImVec2 at((width - wide_at(size, line)) / 2, top);
            list.AddText(&large_font(), size, ImVec2(at.x, at.y + shift), black(0.7F * opacity),
                         line.c_str());
            list.AddText(&large_font(), size, at, white(opacity), line.c_str());
            top += 1.2F * size;
        }
    }
};

/// Darkens the lower part of the picture, without an edge, for text with its top at that share of the height.
void darken(ImDrawList& list, float opacity, float width, float height, float at) {
    const float begin = height * (at - 0.20F), middle = height * (at + 0.02F);
    list.AddRectFilledMultiColor(ImVec2(0, begin), ImVec2(width, middle), black(0), black(0),
                                 black(0.62F * opacity), black(0.62F * opacity));
    list.AddRectFilledMultiColor(ImVec2(0, middle), ImVec2(width, height), black(0.62F * opacity),
                                 black(0.62F * opacity), black(0.85F * opacity), black(0.85F * opacity));
}

/// Proportional to the window, limited by the font's sharpness.
float large_size(float width, float height) {
    const float most = 1.75F * large_font().FontSize;
    return std::clamp(std::min(height * 0.085F, width * 0.075F), 22.0F, std::max(most, 22.0F));
}

/// A line and a smaller one under it, its top at that share of the height; more lines move it up.
void draw_large(const std::string& words, const std::string& small_words, float opacity, float width,
                float height, float at) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float large = large_size(width, height), small = std::max(large * 0.42F, 14.0F);
    const CentredWords first(words, large, width), second(small_words, small, width);
    const float top = std::max(0.0F, height * at - first.more() - second.more());
    darken(list, opacity, width, height, top / height);
    first.draw(list, width, top, opacity);
    second.draw(list, width, top + first.more() + large * 1.25F, 0.85F * opacity);
}

/// `room`: height available, as in draw_kiosk_words.
void draw_caption(const std::string& words, float width, float height, float room) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const CentredWords caption(words, 0.75F * large_size(width, height), width);
    const float top = std::max(0.0F, 0.86F * room - caption.more());
    darken(list, 0.8F, width, height, top / height);
    caption.draw(list, width, top, 1);
}

/// A kiosk's text over the lower part of its picture: the invitation, the notice that the mouse's forces are
/// off and how to restore them (`is_stopped`), or a caption; the last two are within the upper `room` of it.
/// Returns whether there is any. (The demonstrating finger is drawn with the others.)
bool draw_kiosk_words(const KioskFacts& facts, bool is_stopped, float width, float height, float room) {
    const KioskTexts& texts = facts.texts;
    constexpr float at = 0.80F;
    constexpr double fade_s = 1.2;
    if (facts.invited_s) {
        const auto share = static_cast<float>(std::clamp(*facts.invited_s / fade_s, 0.0, 1.0));
        draw_large(texts.invitation, texts.how(facts.by), share * share * (3 - 2 * share), width, height, at);
        return true;
    }
    if (is_stopped)
        draw_large(texts.force_is_off, texts.again(facts.by), 1, width, height, at * room / height);
    else if (!facts.caption.empty())
        draw_caption(facts.caption, width, height, room);
    return is_stopped || !facts.caption.empty();
}

constexpr ImU32 page_ground = IM_COL32(16, 19, 25, 255), page_words_ink = IM_COL32(236, 239, 244, 255),
                page_dim_ink = IM_COL32(165, 173, 186, 255), page_bad_ink = IM_COL32(255, 158, 115, 255),
                page_field = IM_COL32(52, 60, 74, 255), page_lit_field = IM_COL32(74, 86, 106, 255),
                page_accent = IM_COL32(87, 181, 232, 255), page_lit_accent = IM_COL32(128, 204, 245, 255),
                page_dark_ink = IM_COL32(10, 14, 20, 255), page_idle_field = IM_COL32(36, 41, 50, 255),
                page_idle_ink = IM_COL32(118, 126, 140, 255);

constexpr float smallest_page_text = 12;

/// Sizes of a page's parts, from the window's.
struct StudyPage {
    float width, height;
    float text = std::clamp(std::min(height / 22, width / 34), 13.0F, 72.0F);
    float margin = 0.07F * width;
    float room = width - 2 * margin;
    float button_height = std::max(0.115F * height, 2.2F * text);
    float bottom = height - 0.06F * height - button_height;  ///< top of the button
};

/// The largest size, up to `size`, at which it fits into that height and width.
float fitting(const std::string& words, float size, float wide, float high) {
    const auto fits = [&](float tried) {
        const ImVec2 needs = size_of(words, tried, wide);
        return needs.y <= high && needs.x <= wide + 1;
    };
    while (size > smallest_page_text && !fits(size)) size *= 0.95F;
    return std::max(size, smallest_page_text);
}

void draw_text(const std::string& words, float size, ImVec2 at, float wrap, ImU32 ink) {
    for (const std::string& line : lines_of(words)) {
        ImGui::GetWindowDrawList()->AddText(font_of_size(size), size, at, ink, line.c_str(), nullptr, wrap);
        at.y += size_of(line, size, wrap).y + pause_between(size);
    }
}

struct ButtonLook {
    bool is_chosen = false, is_there = true;
    /// An answer under a resting pointer must not look chosen.
    bool is_lit_by_pointer = true;
};

/// A button with text in its middle; returns whether it was clicked.
bool draw_page_button(const char* id, const std::string& words, ImVec2 at, ImVec2 size, float text,
                      ButtonLook look) {
    ImGui::SetCursorScreenPos(at);
    const bool clicked = ImGui::InvisibleButton(id, size);
    const bool is_lit = ImGui::IsItemHovered() && look.is_there && look.is_lit_by_pointer;
    ImU32 back = is_lit ? page_lit_field : page_field, ink = page_words_ink;
    if (look.is_chosen) {
        back = is_lit ? page_lit_accent : page_accent;
        ink = page_dark_ink;
    }
    if (!look.is_there) {
        back = page_idle_field;
        ink = page_idle_ink;
    }
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const float round = 0.25F * text + 3;
    list.AddRectFilled(at, ImVec2(at.x + size.x, at.y + size.y), back, round);
    const float wide = size.x - text, fits = fitting(words, text, wide, size.y - 4);
    const ImVec2 needs = size_of(words, fits, wide);
    draw_text(words, fits, ImVec2(at.x + (size.x - needs.x) / 2, at.y + (size.y - needs.y) / 2), wide, ink);
    return clicked;
}

void draw_answer(const StudyFacts& facts, std::size_t answer, ImVec2 at, ImVec2 size, float text,
                 std::vector<WindowCommand>& asked) {
    if (draw_page_button(("answer" + std::to_string(answer)).c_str(), facts.answers[answer], at, size, text,
                         {.is_chosen = facts.chosen == answer, .is_lit_by_pointer = false}))
        asked.push_back({WindowVerb::answer, static_cast<double>(answer + 1)});
}

/// Adjacent buttons for the answers from `left` on, between the two y of `rows`.
void draw_answers(const StudyFacts& facts, float left, float room, ImVec2 rows, float text,
                  std::vector<WindowCommand>& asked) {
    const auto count = static_cast<float>(facts.answers.size());
    const float gap = 0.35F * text, wide = (room - gap * (count - 1)) / count;
    for (std::size_t k = 0; k < facts.answers.size(); ++k) {
        const ImVec2 at(left + static_cast<float>(k) * (wide + gap), rows.x);
        draw_answer(facts, k, at, ImVec2(wide, rows.y - rows.x), text, asked);
    }
}

/// Numbers, with the meaning of the ends below.
void draw_scale(const StudyFacts& facts, const StudyPage& page, float top, float bottom,
                std::vector<WindowCommand>& asked) {
    const auto count = static_cast<float>(facts.answers.size());
    const float room = std::min(page.room, count * 0.13F * page.width), left = (page.width - room) / 2;
    const float end_room = 0.42F * page.room, end_text = 0.85F * page.text;
    const float ends =
        std::max(size_of(facts.low, end_text, end_room).y, size_of(facts.high, end_text, end_room).y);
    const float high = std::min(0.19F * page.height, bottom - top - ends - 0.4F * page.text);
    const float from = top + (bottom - top - high - ends - 0.4F * page.text) * 0.45F;
    draw_answers(facts, left, room, ImVec2(from, from + high), 1.25F * page.text, asked);
    const float below = from + high + 0.4F * page.text;
    draw_text(facts.low, end_text, ImVec2(left, below), end_room, page_dim_ink);
    const float wide = size_of(facts.high, end_text, end_room).x;
    draw_text(facts.high, end_text, ImVec2(left + room - wide, below), end_room, page_dim_ink);
}

/// Side by side if each fits, otherwise stacked.
void draw_choices(const StudyFacts& facts, const StudyPage& page, float top, float bottom,
                  std::vector<WindowCommand>& asked) {
    const auto count = static_cast<float>(facts.answers.size());
    const float gap = 0.35F * page.text, cell = (page.room - gap * (count - 1)) / count;
    const bool fit = std::ranges::all_of(facts.answers, [&](const std::string& words) {
        return size_of(words, page.text, 0).x < cell - 1.5F * page.text;
    });
    if (fit && facts.answers.size() <= 3) {
        const float high = std::min(0.17F * page.height, bottom - top),
                    from = top + (bottom - top - high) * 0.45F;
        return draw_answers(facts, page.margin, page.room, ImVec2(from, from + high), 1.1F * page.text,
                            asked);
    }
    const float high = std::min(0.12F * page.height, (bottom - top - gap * (count - 1)) / count);
    float at = top + (bottom - top - high * count - gap * (count - 1)) / 2;
    for (std::size_t k = 0; k < facts.answers.size(); ++k, at += high + gap)
        draw_answer(facts, k, ImVec2(page.margin, at), ImVec2(page.room, high), page.text, asked);
}

/// The same width with and without the remaining seconds.
float width_of_go_on(const StudyFacts& facts, float high, float text) {
    return std::max(size_of(facts.go_on + " (00)", text, 0).x + 2 * text, 2.4F * high);
}

/// `right`, `bottom`: its lower right corner.
void draw_go_on(const StudyFacts& facts, float right, float bottom, float high, float text,
                std::vector<WindowCommand>& asked) {
    if (facts.go_on.empty()) return;
    const float wide = width_of_go_on(facts, high, text);
    const std::string words =
        facts.wait_s > 0 ? facts.go_on + " (" + std::to_string(facts.wait_s) + ")" : facts.go_on;
    if (draw_page_button("go on", words, ImVec2(right - wide, bottom - high), ImVec2(wide, high), text,
                         {.is_chosen = true, .is_there = facts.may_go_on}))
        asked.push_back({WindowVerb::go_on});
}

void begin_window(ImVec2 at, ImVec2 size, float opacity) {
    begin_canvas("study", at, size);
    const ImU32 back = (page_ground & 0x00FFFFFFU) | static_cast<ImU32>(255 * opacity) << IM_COL32_A_SHIFT;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRectFullScreen();  // to the last pixel
    list.AddRectFilled(at, ImVec2(at.x + size.x, at.y + size.y), back);
    list.PopClipRect();
}

void begin_page(const StudyFacts& facts, float width, float height, std::vector<WindowCommand>& asked) {
    const StudyPage page{width, height};
    begin_window(ImVec2(0, 0), ImVec2(width, height), 1);
    ImGui::GetWindowDrawList()->AddRectFilled(
        ImVec2(0, 0), ImVec2(width * static_cast<float>(facts.share_done), 0.012F * height), page_accent);
    float top = 0.09F * height;
    if (!facts.title.empty()) {
        const float size = fitting(facts.title, 1.7F * page.text, page.room, 0.25F * height);
        draw_text(facts.title, size, ImVec2(page.margin, top), page.room, page_words_ink);
        top += size_of(facts.title, size, page.room).y + 0.7F * page.text;
    }
    const bool asks = !facts.answers.empty();
    const float end = page.bottom - 0.5F * page.text, high = (asks ? 0.45F : 1.0F) * (end - top);
    const float size = fitting(facts.words, (asks ? 1.2F : 1.0F) * page.text, page.room, high);
    draw_text(facts.words, size, ImVec2(page.margin, top), page.room, page_words_ink);
    top += size_of(facts.words, size, page.room).y + 0.5F * page.text;
    if (asks && facts.is_scale) draw_scale(facts, page, top, end, asked);
    if (asks && !facts.is_scale) draw_choices(facts, page, top, end, asked);
    draw_go_on(facts, width - page.margin, page.bottom + page.button_height, page.button_height,
               1.1F * page.text, asked);
    if (facts.fault.empty()) return;
    const float wide = 0.6F * page.room, small = fitting(facts.fault, page.text, wide, page.button_height);
    draw_text(facts.fault, small, ImVec2(page.margin, page.bottom), wide, page_bad_ink);
}

/// Below the touched picture: the instruction, and the button.
void begin_strip(const StudyFacts& facts, float width, float height, std::vector<WindowCommand>& asked) {
    const StudyPage page{width, height};
    const float text = 0.85F * page.text, gap = 0.6F * text, high = study_strip_height(width, height);
    begin_window(ImVec2(0, height - high), ImVec2(width, high), 0.82F);
    const float button = high - 1.2F * gap;
    draw_go_on(facts, width - gap, height - 0.6F * gap, button, page.text, asked);
    const float taken = facts.go_on.empty() ? 0 : width_of_go_on(facts, button, page.text);
    const float wide = width - taken - 3 * gap, size = fitting(facts.words, text, wide, high - gap);
    const float needs = size_of(facts.words, size, wide).y;
    draw_text(facts.words, size, ImVec2(gap, height - high + (high - needs) / 2), wide, page_words_ink);
}

}  // namespace

/// Texts leave room for the bar, shown or hidden, so that nothing moves.
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
    const float right = width - panel_margin * scale_, widest = widest_scale * scale_;
    const bool is_beside = !kiosk.has_bar || right - widest > bar.right();
    if (kiosk.scale && !has_words)
        draw_overlay_scale(*kiosk.scale, right, (is_beside ? height : above) - panel_margin * scale_, widest,
                           scale_);
    if (!kiosk.has_bar && kiosk.is_turned) draw_turn_back(kiosk.texts.turn_back, width, asked);
    if (!kiosk.has_bar || !bar_shown) return;
    bar.draw(asked);
    boxes_.push_back(bar_box_);
}

/// For visitors without keys, and participants of a study.
void WindowPanel::draw_turn_back(const std::string& words, float width, std::vector<WindowCommand>& asked) {
    const float m = panel_margin * scale_;
    begin_box("turn back", {.x = width - m, .y = m, .pivot_x = 1});
    note_box();
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(12 * scale_, 10 * scale_));
    if (ImGui::Button((words + "##turn back").c_str())) asked.push_back({WindowVerb::home});
    ImGui::PopStyleVar();
    ImGui::End();
}

void draw_stop(float width, float height) {
    // Above the bar; in a low window also above the values at the pointer.
    draw_large(stop_words, go_on_words, 1, width, height, height < 32 * ImGui::GetFontSize() ? 0.44F : 0.62F);
}

void begin_study(const StudyFacts& facts, float width, float height, std::vector<WindowCommand>& asked) {
    facts.is_page ? begin_page(facts, width, height, asked) : begin_strip(facts, width, height, asked);
}

float study_strip_height(float width, float height) {
    return std::max(3.4F * 0.85F * StudyPage{width, height}.text, 44.0F);
}

}  // namespace touchable
