#include "player/window/invitation.hpp"

#include <imgui.h>

#include <algorithm>
#include <string>
#include <vector>

namespace touchable {
namespace {

constexpr const char* stopped = "Force is off";
constexpr const char* how_it_goes_on = "F brings it back";
constexpr const char* all_words = "Force is off F brings it back";
constexpr double fade_s = 1.2;

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

/// Words in the middle of the width, with a soft dark edge: they have to be read over any picture. Smaller
/// where they would not fit, down to a part of their size, and then in several lines.
struct CentredWords {
    std::vector<std::string> lines;
    float size;

    CentredWords(const std::string& words, float wanted, float width) : size(wanted) {
        constexpr float smallest = 11, smallest_part = 0.7F;
        const float room = 0.94F * width, wide = wide_at(size, words);
        if (wide > room) size = std::max({smallest, smallest_part * size, size * room / wide});
        constexpr float rounding = 1.01F;  // a line just made as wide as the room stays whole
        const char *from = words.data(), *const end = from + words.size();
        while (from < end) {
            const char* to =
                large_font().CalcWordWrapPositionA(size / large_font().FontSize, from, end, rounding * room);
            if (to == from) ++to;
            lines.emplace_back(from, to);
            for (from = to; from < end && *from == ' ';) ++from;
        }
    }
    /// More than one line has.
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

/// The lower part of the picture goes dark for words whose top is at that share of the height, without an
/// edge.
void darken(ImDrawList& list, float opacity, float width, float height, float at) {
    const float begin = height * (at - 0.20F), middle = height * (at + 0.02F);
    list.AddRectFilledMultiColor(ImVec2(0, begin), ImVec2(width, middle), black(0), black(0),
                                 black(0.62F * opacity), black(0.62F * opacity));
    list.AddRectFilledMultiColor(ImVec2(0, middle), ImVec2(width, height), black(0.62F * opacity),
                                 black(0.62F * opacity), black(0.85F * opacity), black(0.85F * opacity));
}

/// As the window is large, as far as the letters are not blurred by it.
float large_size(float width, float height) {
    const float most = 1.75F * large_font().FontSize;
    return std::clamp(std::min(height * 0.085F, width * 0.075F), 22.0F, std::max(most, 22.0F));
}

/// A line and a smaller one under it, whose top is at that share of the height; more lines of either go up.
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

/// `room`: of the height, as of draw_kiosk_words.
void draw_caption(const std::string& words, float width, float height, float room) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const CentredWords caption(words, 0.75F * large_size(width, height), width);
    const float top = std::max(0.0F, 0.86F * room - caption.more());
    darken(list, 0.8F, width, height, top / height);
    caption.draw(list, width, top, 1);
}

}  // namespace

const char* invitation_words() {
    return all_words;
}

bool draw_kiosk_words(const KioskFacts& facts, bool is_stopped, float width, float height, float room) {
    const KioskTexts& texts = facts.texts;
    constexpr float at = 0.80F;
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

void draw_stop(float width, float height) {
    draw_large(stopped, how_it_goes_on, 1, width, height, 0.62F);  // above the bar
}

}  // namespace touchable
