#include "player/window/invitation.hpp"

#include <imgui.h>

#include <algorithm>

namespace touchable {
namespace {

constexpr const char* title = "Touch the picture";
constexpr const char* how = "Move, hold the button, and feel";
constexpr const char* how_held = "Take the handle, and feel";
constexpr const char* all_words = "Touch the picture Move, hold the button, and feel Take the handle";
constexpr double fade_s = 1.2;

ImU32 white(float opacity) {
    return IM_COL32(255, 255, 255, static_cast<int>(255 * opacity));
}
ImU32 black(float opacity) {
    return IM_COL32(4, 7, 12, static_cast<int>(255 * opacity));
}

/// In the middle of the width, with a soft dark edge: it has to be read over any picture.
void draw_words(ImDrawList& list, ImFont* font, float size, const char* words, float middle, float top,
                float opacity) {
    const float wide = font->CalcTextSizeA(size, 1e6F, 0, words).x;
    const ImVec2 at(middle - wide / 2, top);
    const float shift = std::max(1.0F, size / 28);
    list.AddText(font, size, ImVec2(at.x, at.y + shift), black(0.7F * opacity), words);
    list.AddText(font, size, at, white(opacity), words);
}

}  // namespace

const char* invitation_words() {
    return all_words;
}

void draw_invitation(double seconds, float width, float height, bool held) {
    const auto share = static_cast<float>(std::clamp(seconds / fade_s, 0.0, 1.0));
    const float opacity = share * share * (3 - 2 * share);
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    ImFont* const font = fonts.Fonts.back();
    const float large = std::clamp(std::min(height * 0.085F, width * 0.075F), 22.0F, 96.0F);
    const float small = std::max(large * 0.42F, 14.0F);
    // The lower part of the picture goes dark for the words, without an edge.
    const float begin = height * 0.60F, middle = height * 0.82F;
    list.AddRectFilledMultiColor(ImVec2(0, begin), ImVec2(width, middle), black(0), black(0),
                                 black(0.62F * opacity), black(0.62F * opacity));
    list.AddRectFilledMultiColor(ImVec2(0, middle), ImVec2(width, height), black(0.62F * opacity),
                                 black(0.62F * opacity), black(0.85F * opacity), black(0.85F * opacity));
    const float top = height * 0.80F;
    draw_words(list, font, large, title, width / 2, top, opacity);
    draw_words(list, font, small, held ? how_held : how, width / 2, top + large * 1.25F, 0.85F * opacity);
}

}  // namespace touchable
