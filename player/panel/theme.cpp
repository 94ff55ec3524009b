#include "player/panel/theme.hpp"

#include <fontconfig/fontconfig.h>
#include <imgui.h>

#include "player/panel/invitation.hpp"

namespace touchable {
namespace {

constexpr double text_pixels = 15, large_text_pixels = 56;

void colour(ImGuiStyle& style) {
    const ImVec4 ground(0.07F, 0.08F, 0.10F, 0.86F), field(0.20F, 0.22F, 0.26F, 0.90F);
    const ImVec4 field_lit(0.28F, 0.31F, 0.37F, 1), accent(0.34F, 0.71F, 0.91F, 1);
    const ImVec4 accent_lit(0.50F, 0.80F, 0.96F, 1), words(0.93F, 0.94F, 0.96F, 1);
    ImVec4* const c = style.Colors;
    c[ImGuiCol_Text] = words;
    c[ImGuiCol_TextDisabled] = ImVec4(0.62F, 0.66F, 0.72F, 1);
    c[ImGuiCol_WindowBg] = c[ImGuiCol_PopupBg] = ground;
    c[ImGuiCol_Border] = ImVec4(1, 1, 1, 0.08F);
    for (const int at : {ImGuiCol_FrameBg, ImGuiCol_Button, ImGuiCol_Header}) c[at] = field;
    for (const int at : {ImGuiCol_FrameBgHovered, ImGuiCol_FrameBgActive, ImGuiCol_ButtonHovered,
                         ImGuiCol_ButtonActive, ImGuiCol_HeaderHovered, ImGuiCol_HeaderActive})
        c[at] = field_lit;
    for (const int at : {ImGuiCol_SliderGrab, ImGuiCol_CheckMark, ImGuiCol_PlotLines, ImGuiCol_PlotHistogram})
        c[at] = accent;
    c[ImGuiCol_SliderGrabActive] = accent_lit;
    c[ImGuiCol_TitleBg] = c[ImGuiCol_TitleBgActive] = ground;
}

}  // namespace

std::string font_file(const char* family) {
    std::string file;
    FcPattern* const wanted = FcNameParse(reinterpret_cast<const FcChar8*>(family));
    if (!wanted) return file;
    FcConfigSubstitute(nullptr, wanted, FcMatchPattern);
    FcDefaultSubstitute(wanted);
    FcResult result = FcResultMatch;
    FcPattern* const found = FcFontMatch(nullptr, wanted, &result);
    FcChar8* name = nullptr;
    if (found && FcPatternGetString(found, FC_FILE, 0, &name) == FcResultMatch && name)
        file = reinterpret_cast<const char*>(name);
    if (found) FcPatternDestroy(found);
    FcPatternDestroy(wanted);
    return file;
}

void apply_theme(double scale) {
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    colour(style);
    style.WindowRounding = 8;
    style.FrameRounding = style.GrabRounding = style.PopupRounding = 5;
    style.WindowBorderSize = 1;
    style.WindowPadding = ImVec2(12, 10);
    style.FramePadding = ImVec2(8, 4);
    style.ItemSpacing = ImVec2(8, 6);
    style.GrabMinSize = 12;
    style.ScaleAllSizes(static_cast<float>(scale));
    ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    // Latin, and what the panel uses besides: the multiplication sign, the degree and the micro sign.
    const std::string file = font_file("sans");
    ImFont* font = nullptr;
    if (file.ends_with(".ttf") || file.ends_with(".otf"))
        font = fonts.AddFontFromFileTTF(file.c_str(), static_cast<float>(text_pixels * scale));
    if (font) {
        // Of the large size only what is written in it.
        ImFontGlyphRangesBuilder letters;
        static ImVector<ImWchar> ranges;
        letters.AddText(invitation_words());
        ranges.clear();
        letters.BuildRanges(&ranges);
        fonts.AddFontFromFileTTF(file.c_str(), static_cast<float>(large_text_pixels * scale), nullptr,
                                 ranges.Data);
    } else {
        fonts.AddFontDefault();
        ImGui::GetIO().FontGlobalScale = static_cast<float>(scale);
    }
}

}  // namespace touchable
