#include "player/panel/invitation.hpp"

#include <imgui.h>

#include <algorithm>
#include <string>

namespace touchable {
namespace {

constexpr const char* stopped = "Force is off";
constexpr const char* how_it_goes_on = "F brings it back";
constexpr const char* all_words = "Force is off F brings it back";
constexpr double fade_s = 1.2;

ImU32 white(float opacity) {
    return IM_COL32(255, 255, 255, static_cast<int>(255 * opacity));
}
ImU32 black(float opacity) {
    return IM_COL32(4, 7, 12, static_cast<int>(255 * opacity));
}

/// In the middle of the width, with a soft dark edge: it has to be read over any picture. Smaller where it
/// would not fit.
void draw_centred(ImDrawList& list, ImFont* font, float size, const std::string& words, float width,
                  float top, float opacity) {
    constexpr float smallest = 11;
    float wide = font->CalcTextSizeA(size, 1e6F, 0, words.c_str()).x;
    if (wide > 0.94F * width) {
        size = std::max(smallest, size * 0.94F * width / wide);
        wide = font->CalcTextSizeA(size, 1e6F, 0, words.c_str()).x;
    }
    const ImVec2 at((width - wide) / 2, top);
    const float shift = std::max(1.0F, size / 28);
    list.AddText(font, size, ImVec2(at.x, at.y + shift), black(0.7F * opacity), words.c_str());
    list.AddText(font, size, at, white(opacity), words.c_str());
}

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
    const float most = 1.75F * ImGui::GetIO().Fonts->Fonts.back()->FontSize;
    return std::clamp(std::min(height * 0.085F, width * 0.075F), 22.0F, std::max(most, 22.0F));
}

/// A line and a smaller one under it, whose top is at that share of the height.
void draw_large(const std::string& words, const std::string& small_words, float opacity, float width,
                float height, float at) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    ImFont* const font = ImGui::GetIO().Fonts->Fonts.back();
    const float large = large_size(width, height), small = std::max(large * 0.42F, 14.0F);
    darken(list, opacity, width, height, at);
    const float top = height * at;
    draw_centred(list, font, large, words, width, top, opacity);
    draw_centred(list, font, small, small_words, width, top + large * 1.25F, 0.85F * opacity);
}

/// `room`: of the height, as of draw_kiosk_words.
void draw_caption(const std::string& words, float width, float height, float room) {
    const float at = 0.86F * room / height;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    darken(list, 0.8F, width, height, at);
    draw_centred(list, ImGui::GetIO().Fonts->Fonts.back(), 0.75F * large_size(width, height), words, width,
                 height * at, 1);
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
