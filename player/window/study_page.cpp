#include "player/window/study_page.hpp"

#include <imgui.h>

#include <algorithm>
#include <sstream>

#include "player/window/panel_rows.hpp"

namespace touchable {
namespace {

constexpr ImU32 page_ground = IM_COL32(16, 19, 25, 255), page_words_ink = IM_COL32(236, 239, 244, 255),
                page_dim_ink = IM_COL32(165, 173, 186, 255), page_bad_ink = IM_COL32(255, 158, 115, 255),
                page_field = IM_COL32(52, 60, 74, 255), page_lit_field = IM_COL32(74, 86, 106, 255),
                page_accent = IM_COL32(87, 181, 232, 255), page_lit_accent = IM_COL32(128, 204, 245, 255),
                page_dark_ink = IM_COL32(10, 14, 20, 255), page_idle_field = IM_COL32(36, 41, 50, 255),
                page_idle_ink = IM_COL32(118, 126, 140, 255);
constexpr float smallest_page_text = 12;

/// Of a page: the sizes of its parts, by those of the window.
struct Page {
    float width, height;
    float text = std::clamp(std::min(height / 22, width / 34), 13.0F, 72.0F);
    float margin = 0.07F * width;
    float room = width - 2 * margin;
    float button_height = std::max(0.115F * height, 2.2F * text);
    float bottom = height - 0.06F * height - button_height;  ///< where the button begins
};

/// From one line of a text to the next, beside its height.
float pause_between(float size) {
    return 0.35F * size;
}

std::vector<std::string> lines_of(const std::string& words) {
    std::vector<std::string> lines;
    std::istringstream in(words);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

/// Of its lines, each of which may take several: no wider than `wrap`; 0: however wide.
ImVec2 size_of(const std::string& words, float size, float wrap) {
    ImVec2 all(0, 0);
    for (const std::string& line : lines_of(words)) {
        const ImVec2 one = font_of_size(size)->CalcTextSizeA(size, 1e6F, wrap, line.c_str());
        all = ImVec2(std::max(all.x, one.x), all.y + one.y + (all.y > 0 ? pause_between(size) : 0));
    }
    return all;
}

/// The largest size, up to `size`, in which it is no higher and no line is wider.
float fitting(const std::string& words, float size, float wide, float high) {
    const auto fits = [&](float tried) {
        const ImVec2 needs = size_of(words, tried, wide);
        return needs.y <= high && needs.x <= wide + 1;
    };
    while (size > smallest_page_text && !fits(size)) size *= 0.95F;
    return std::max(size, smallest_page_text);
}

void draw_words(const std::string& words, float size, ImVec2 at, float wrap, ImU32 ink) {
    for (const std::string& line : lines_of(words)) {
        ImGui::GetWindowDrawList()->AddText(font_of_size(size), size, at, ink, line.c_str(), nullptr, wrap);
        at.y += size_of(line, size, wrap).y + pause_between(size);
    }
}

struct Look {
    bool is_chosen = false, is_there = true;
    /// An answer under a pointer that rests there must not look chosen.
    bool is_lit_by_pointer = true;
};

/// A button with words in its middle; whether it was clicked.
bool draw_button(const char* id, const std::string& words, ImVec2 at, ImVec2 size, float text, Look look) {
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
    draw_words(words, fits, ImVec2(at.x + (size.x - needs.x) / 2, at.y + (size.y - needs.y) / 2), wide, ink);
    return clicked;
}

void choose(std::size_t answer, std::vector<WindowCommand>& asked) {
    asked.push_back({WindowVerb::answer, static_cast<double>(answer + 1)});
}

/// `count` buttons side by side from `left` on, between `top` and `bottom`.
void draw_row(const StudyFacts& facts, float left, float room, ImVec2 rows, float text,
              std::vector<WindowCommand>& asked) {
    const auto count = static_cast<float>(facts.answers.size());
    const float gap = 0.35F * text, wide = (room - gap * (count - 1)) / count;
    for (std::size_t k = 0; k < facts.answers.size(); ++k) {
        const ImVec2 at(left + static_cast<float>(k) * (wide + gap), rows.x);
        if (draw_button(("answer" + std::to_string(k)).c_str(), facts.answers[k], at,
                        ImVec2(wide, rows.y - rows.x), text,
                        {.is_chosen = facts.chosen == k, .is_lit_by_pointer = false}))
            choose(k, asked);
    }
}

/// Numbers, with the meaning of their ends below.
void draw_scale(const StudyFacts& facts, const Page& page, float top, float bottom,
                std::vector<WindowCommand>& asked) {
    const auto count = static_cast<float>(facts.answers.size());
    const float room = std::min(page.room, count * 0.13F * page.width), left = (page.width - room) / 2;
    const float end_room = 0.42F * page.room, end_text = 0.85F * page.text;
    const float ends =
        std::max(size_of(facts.low, end_text, end_room).y, size_of(facts.high, end_text, end_room).y);
    const float high = std::min(0.19F * page.height, bottom - top - ends - 0.4F * page.text);
    const float from = top + (bottom - top - high - ends - 0.4F * page.text) * 0.45F;
    draw_row(facts, left, room, ImVec2(from, from + high), 1.25F * page.text, asked);
    const float below = from + high + 0.4F * page.text;
    draw_words(facts.low, end_text, ImVec2(left, below), end_room, page_dim_ink);
    const float wide = size_of(facts.high, end_text, end_room).x;
    draw_words(facts.high, end_text, ImVec2(left + room - wide, below), end_room, page_dim_ink);
}

/// Side by side where each fits, otherwise one below the other.
void draw_choices(const StudyFacts& facts, const Page& page, float top, float bottom,
                  std::vector<WindowCommand>& asked) {
    const auto count = static_cast<float>(facts.answers.size());
    const float gap = 0.35F * page.text, cell = (page.room - gap * (count - 1)) / count;
    const bool fit = std::ranges::all_of(facts.answers, [&](const std::string& words) {
        return size_of(words, page.text, 0).x < cell - 1.5F * page.text;
    });
    if (fit && facts.answers.size() <= 3) {
        const float high = std::min(0.17F * page.height, bottom - top),
                    from = top + (bottom - top - high) * 0.45F;
        return draw_row(facts, page.margin, page.room, ImVec2(from, from + high), 1.1F * page.text, asked);
    }
    const float high = std::min(0.12F * page.height, (bottom - top - gap * (count - 1)) / count);
    float at = top + (bottom - top - high * count - gap * (count - 1)) / 2;
    for (std::size_t k = 0; k < facts.answers.size(); ++k, at += high + gap)
        if (draw_button(("answer" + std::to_string(k)).c_str(), facts.answers[k], ImVec2(page.margin, at),
                        ImVec2(page.room, high), page.text,
                        {.is_chosen = facts.chosen == k, .is_lit_by_pointer = false}))
            choose(k, asked);
}

/// As wide while it says how long it waits as afterwards.
float width_of_go_on(const StudyFacts& facts, float high, float text) {
    return std::max(size_of(facts.go_on + " (00)", text, 0).x + 2 * text, 2.4F * high);
}

/// `right`, `bottom`: its corner there.
void draw_go_on(const StudyFacts& facts, float right, float bottom, float high, float text,
                std::vector<WindowCommand>& asked) {
    if (facts.go_on.empty()) return;
    const float wide = width_of_go_on(facts, high, text);
    const std::string words =
        facts.wait_s > 0 ? facts.go_on + " (" + std::to_string(facts.wait_s) + ")" : facts.go_on;
    if (draw_button("go on", words, ImVec2(right - wide, bottom - high), ImVec2(wide, high), text,
                    {.is_chosen = true, .is_there = facts.may_go_on}))
        asked.push_back({WindowVerb::go_on});
}

void begin_window(ImVec2 at, ImVec2 size, float opacity) {
    ImGui::SetNextWindowPos(at);
    ImGui::SetNextWindowSize(size);
    ImGui::SetNextWindowBgAlpha(0);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));  // beyond which nothing is drawn
    ImGui::Begin("study", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing);
    ImGui::PopStyleVar(2);
    const ImU32 back = (page_ground & 0x00FFFFFFU) | static_cast<ImU32>(255 * opacity) << IM_COL32_A_SHIFT;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRectFullScreen();  // to the last pixel
    list.AddRectFilled(at, ImVec2(at.x + size.x, at.y + size.y), back);
    list.PopClipRect();
}

void begin_page(const StudyFacts& facts, float width, float height, std::vector<WindowCommand>& asked) {
    const Page page{width, height};
    begin_window(ImVec2(0, 0), ImVec2(width, height), 1);
    ImGui::GetWindowDrawList()->AddRectFilled(
        ImVec2(0, 0), ImVec2(width * static_cast<float>(facts.share_done), 0.012F * height), page_accent);
    float top = 0.09F * height;
    if (!facts.title.empty()) {
        const float size = fitting(facts.title, 1.7F * page.text, page.room, 0.25F * height);
        draw_words(facts.title, size, ImVec2(page.margin, top), page.room, page_words_ink);
        top += size_of(facts.title, size, page.room).y + 0.7F * page.text;
    }
    const bool asks = !facts.answers.empty();
    const float end = page.bottom - 0.5F * page.text, high = (asks ? 0.45F : 1.0F) * (end - top);
    const float size = fitting(facts.words, (asks ? 1.2F : 1.0F) * page.text, page.room, high);
    draw_words(facts.words, size, ImVec2(page.margin, top), page.room, page_words_ink);
    top += size_of(facts.words, size, page.room).y + 0.5F * page.text;
    if (asks && facts.is_scale) draw_scale(facts, page, top, end, asked);
    if (asks && !facts.is_scale) draw_choices(facts, page, top, end, asked);
    draw_go_on(facts, width - page.margin, page.bottom + page.button_height, page.button_height,
               1.1F * page.text, asked);
    if (facts.fault.empty()) return;
    const float wide = 0.6F * page.room, small = fitting(facts.fault, page.text, wide, page.button_height);
    draw_words(facts.fault, small, ImVec2(page.margin, page.bottom), wide, page_bad_ink);
}

/// Below the picture that is touched: what to do there, and the button.
void begin_strip(const StudyFacts& facts, float width, float height, std::vector<WindowCommand>& asked) {
    const Page page{width, height};
    const float text = 0.85F * page.text, gap = 0.6F * text, high = study_strip_height(width, height);
    begin_window(ImVec2(0, height - high), ImVec2(width, high), 0.82F);
    const float button = high - 1.2F * gap;
    draw_go_on(facts, width - gap, height - 0.6F * gap, button, page.text, asked);
    const float taken = facts.go_on.empty() ? 0 : width_of_go_on(facts, button, page.text);
    const float wide = width - taken - 3 * gap, size = fitting(facts.words, text, wide, high - gap);
    const float needs = size_of(facts.words, size, wide).y;
    draw_words(facts.words, size, ImVec2(gap, height - high + (high - needs) / 2), wide, page_words_ink);
}

}  // namespace

float study_strip_height(float width, float height) {
    return std::max(3.4F * 0.85F * Page{width, height}.text, 44.0F);
}

void begin_study(const StudyFacts& facts, float width, float height, std::vector<WindowCommand>& asked) {
    facts.is_page ? begin_page(facts, width, height, asked) : begin_strip(facts, width, height, asked);
}

}  // namespace touchable
