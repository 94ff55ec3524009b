#include "player/panel/invitation.hpp"

#include <imgui.h>

#include <algorithm>

namespace touchable {
namespace {

constexpr const char* title = "Touch the picture";
constexpr const char* how = "Move, hold the button, and feel";
constexpr const char* how_held = "Take the handle, and feel";
constexpr const char* stopped = "Force is off";
constexpr const char* how_it_goes_on = "F brings it back";
constexpr const char* how_kiosk_goes_on = "Press to feel again";
constexpr const char* all_words =
    "Touch the picture Move, hold the button, and feel Take the handle Force is off F brings it back "
    "Press to feel again";
constexpr double fade_s = 1.2;

ImU32 white(float opacity) {
    return IM_COL32(255, 255, 255, static_cast<int>(255 * opacity));
}
ImU32 black(float opacity) {
    return IM_COL32(4, 7, 12, static_cast<int>(255 * opacity));
}

/// In the middle of the width, with a soft dark edge: it has to be read over any picture.
void draw_centred(ImDrawList& list, ImFont* font, float size, const char* words, float middle, float top,
                  float opacity) {
    const float wide = font->CalcTextSizeA(size, 1e6F, 0, words).x;
    const ImVec2 at(middle - wide / 2, top);
    const float shift = std::max(1.0F, size / 28);
    list.AddText(font, size, ImVec2(at.x, at.y + shift), black(0.7F * opacity), words);
    list.AddText(font, size, at, white(opacity), words);
}

/// A line and a smaller one under it, whose top is at that share of the height.
void draw_large(const char* words, const char* small_words, float opacity, float width, float height,
                float at) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    ImFont* const font = fonts.Fonts.back();
    const float large = std::clamp(std::min(height * 0.085F, width * 0.075F), 22.0F, 96.0F);
    const float small = std::max(large * 0.42F, 14.0F);
    // The lower part of the picture goes dark for the words, without an edge.
    const float begin = height * (at - 0.20F), middle = height * (at + 0.02F);
    list.AddRectFilledMultiColor(ImVec2(0, begin), ImVec2(width, middle), black(0), black(0),
                                 black(0.62F * opacity), black(0.62F * opacity));
    list.AddRectFilledMultiColor(ImVec2(0, middle), ImVec2(width, height), black(0.62F * opacity),
                                 black(0.62F * opacity), black(0.85F * opacity), black(0.85F * opacity));
    const float top = height * at;
    draw_centred(list, font, large, words, width / 2, top, opacity);
    draw_centred(list, font, small, small_words, width / 2, top + large * 1.25F, 0.85F * opacity);
}

}  // namespace

const char* invitation_words() {
    return all_words;
}

void draw_invitation(double seconds, float width, float height, bool held) {
    const auto share = static_cast<float>(std::clamp(seconds / fade_s, 0.0, 1.0));
    draw_large(title, held ? how_held : how, share * share * (3 - 2 * share), width, height, 0.80F);
}

void draw_stop(float width, float height, bool is_kiosk) {
    // Above the bar of a window that has one.
    draw_large(stopped, is_kiosk ? how_kiosk_goes_on : how_it_goes_on, 1, width, height,
               is_kiosk ? 0.80F : 0.62F);
}

}  // namespace touchable
