// SPDX-License-Identifier: Apache-2.0
// Dear ImGui: its input, colours and fonts, from the typefaces that fontconfig finds.

#include "player/window/imgui_layer.hpp"

#include <fontconfig/fontconfig.h>
#include <imgui.h>
#include <unistd.h>

#include <memory>
#include <set>
#include <utility>

#include "engine/base/same_bits.hpp"
#include "player/window/panel_parts.hpp"

namespace touchable {
namespace {

using Letters = std::set<char32_t>;
using Pattern = std::unique_ptr<FcPattern, decltype(&FcPatternDestroy)>;

Letters letters_of(const std::string& words) {
    Letters letters;
    const auto* at = reinterpret_cast<const FcChar8*>(words.data());
    for (int left = static_cast<int>(words.size()); left > 0;) {
        FcChar32 letter = 0;
        const int taken = FcUtf8ToUcs4(at, &letter, left);
        if (taken <= 0) break;  // invalid UTF-8, refused when the words were read
        letters.insert(letter);
        at += taken;
        left -= taken;
    }
    return letters;
}

std::string utf8(const Letters& letters) {
    std::string text;
    for (const char32_t letter : letters) {
        FcChar8 bytes[FC_UTF8_MAX_LEN];
        const int count = FcUcs4ToUtf8(letter, bytes);
        text.append(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(count));
    }
    return text;
}

/// nullopt: this process cannot read it, or Dear ImGui cannot, which needs outlines of one colour.
std::optional<FontFace> face_of(FcPattern* font) {
    const auto is = [font](const char* what) {
        FcBool value = FcFalse;
        return FcPatternGetBool(font, what, 0, &value) == FcResultMatch && value;
    };
    const auto words = [font](const char* what) {
        FcChar8* value = nullptr;
        const bool is_there = FcPatternGetString(font, what, 0, &value) == FcResultMatch && value;
        return is_there ? std::string(reinterpret_cast<const char*>(value)) : std::string();
    };
    const std::string format = words(FC_FONTFORMAT);
    if ((format != "TrueType" && format != "CFF") || !is(FC_OUTLINE) || is(FC_COLOR)) return {};
    FontFace face{words(FC_FILE)};
    if (::access(face.file.c_str(), R_OK) != 0) return {};
    FcPatternGetInteger(font, FC_INDEX, 0, &face.index);
    face.index &= 0xFFFF;  // the upper bits name an instance of a variable font; ImGui draws its default one
    return face;
}

/// Moves the letters that a typeface has from `wanted` to the result.
Letters taken_by(FcPattern* font, Letters& wanted) {
    Letters taken;
    FcCharSet* has = nullptr;
    if (FcPatternGetCharSet(font, FC_CHARSET, 0, &has) != FcResultMatch) return taken;
    std::erase_if(wanted, [&](char32_t letter) {
        return FcCharSetHasChar(has, letter) && taken.insert(letter).second;
    });
    return taken;
}

Pattern sans_of(const std::string& language) {
    Pattern wanted(FcNameParse(reinterpret_cast<const FcChar8*>("sans")), &FcPatternDestroy);
    if (!wanted) return wanted;
    // Typefaces tag Chinese with a country.
    const std::string named = language == "zh" ? "zh-cn" : language;
    if (!named.empty())
        FcPatternAddString(wanted.get(), FC_LANG, reinterpret_cast<const FcChar8*>(named.c_str()));
    FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
    FcDefaultSubstitute(wanted.get());
    return wanted;
}

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

/// Glyph ranges of both font sizes; an atlas reads them until it is built.
struct LetterRanges {
    ImVector<ImWchar> text, large;
    std::vector<ImVector<ImWchar>> others;
};

void set_range(ImVector<ImWchar>& to, const std::string& letters, const ImWchar* usual = nullptr) {
    ImFontGlyphRangesBuilder builder;
    if (usual) builder.AddRanges(usual);
    // Dear ImGui's replacements of missing letters.
    builder.AddChar(IM_UNICODE_CODEPOINT_INVALID);
    builder.AddChar('?');
    builder.AddText(letters.c_str());
    to.clear();
    builder.BuildRanges(&to);
}

/// `merged`: into the last added font.
bool add_font(const FontFace& face, float pixels, const ImWchar* letters, bool merged) {
    ImFontConfig config;
    config.FontNo = face.index;
    config.MergeMode = merged;
    // AddFontFromFileTTF would abort the program.
    if (::access(face.file.c_str(), R_OK) != 0) return false;
    return ImGui::GetIO().Fonts->AddFontFromFileTTF(face.file.c_str(), pixels, &config, letters);
}

/// Builds the atlas in both sizes: the usual typeface's letters, and those of the fallbacks. False if a
/// fallback cannot be read.
bool build_letters(const FontFallback& found, const std::string& kiosk_words, double scale) {
    static LetterRanges ranges;
    ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    fonts.Clear();
    ImGui::GetIO().FontGlobalScale = 1;
    if (!found.usual) {
        fonts.AddFontDefault();
        ImGui::GetIO().FontGlobalScale = static_cast<float>(scale);
        return fonts.Build();
    }
    // Latin, including the panel's multiplication, degree and micro signs. The large size has only the texts
    // that use it.
    set_range(ranges.text, kiosk_words, fonts.GetGlyphRangesDefault());
    set_range(ranges.large, std::string(stop_words) + go_on_words + empty_page_title + kiosk_words);
    ranges.others.resize(found.others.size());
    for (std::size_t k = 0; k < found.others.size(); ++k)
        set_range(ranges.others[k], found.others[k].letters);
    for (const bool is_large : {false, true}) {
        const auto pixels = static_cast<float>((is_large ? large_text_pixels : text_pixels) * scale);
        const ImWchar* const own = (is_large ? ranges.large : ranges.text).Data;
        if (!add_font(*found.usual, pixels, own, false)) return false;
        for (std::size_t k = 0; k < found.others.size(); ++k)
            if (!add_font(found.others[k].face, pixels, ranges.others[k].Data, true)) return false;
    }
    const bool is_built = fonts.Build();
    fonts.ClearInputData();  // a Chinese font has 20 MB, and is there twice
    return is_built;
}

/// Sets the current ImGui context's fonts; `scale` as in ScreenSize. Uses the system's sans-serif typeface if
/// there is one.
void set_fonts(FontFallback& found, const std::string& kiosk_words, double scale) {
    if (build_letters(found, kiosk_words, scale)) return;
    for (const FallbackFont& other : std::exchange(found.others, {})) found.unwritten += other.letters;
    if (build_letters(found, kiosk_words, scale)) return;
    found.usual.reset();
    build_letters(found, kiosk_words, scale);
}

/// The current ImGui context's colours and distances; `scale` as in ScreenSize.
void apply_theme(double scale) {
    ImGuiStyle& style = ImGui::GetStyle();
    style = ImGuiStyle();
    colour(style);
    style.WindowRounding = 8;
    style.FrameRounding = style.GrabRounding = style.PopupRounding = 5;
    style.WindowBorderSize = 1;
    style.WindowPadding = ImVec2(12, 10);
    style.FramePadding = ImVec2(8, 4);
    style.ItemSpacing = ImVec2(8, 6);
    style.GrabMinSize = 12;
    style.ScaleAllSizes(static_cast<float>(scale));
}

/// Keys of lists and sliders; ImGui 1.86 knows a key by its place here.
constexpr std::pair<std::string_view, ImGuiKey> panel_keys[] = {{"left", ImGuiKey_LeftArrow},
                                                                {"right", ImGuiKey_RightArrow},
                                                                {"up", ImGuiKey_UpArrow},
                                                                {"down", ImGuiKey_DownArrow},
                                                                {"space", ImGuiKey_Space}};

int button_of(const std::string& word) {
    return word == "left" ? 0 : (word == "right" ? 1 : 2);
}

void tell(ImGuiIO& io, const InputEvent& event) {
    using Kind = InputEvent::Kind;
    switch (event.kind) {
        case Kind::moved:
            io.MousePos = ImVec2(static_cast<float>(event.x), static_cast<float>(event.y));
            break;
        case Kind::left_window:
            io.MousePos = ImVec2(-FLT_MAX, -FLT_MAX);
            break;
        case Kind::pressed:
        case Kind::released:
            io.MouseDown[button_of(event.word)] = event.kind == Kind::pressed;
            break;
        case Kind::wheel:
            io.MouseWheel += static_cast<float>(event.y);
            break;
        case Kind::key:
            for (std::size_t k = 0; k < std::size(panel_keys); ++k)
                io.KeysDown[k] |= panel_keys[k].first == (event.word == "enter" ? "space" : event.word);
            break;
        default:  // touches on a panel arrive as pointer events
            break;
    }
}

}  // namespace

FontFallback find_fonts(const std::string& words, const std::string& language) {
    FontFallback fonts;
    Letters wanted = letters_of(words), beyond;
    std::erase_if(wanted, [&](char32_t letter) {
        return letter > IM_UNICODE_CODEPOINT_MAX && beyond.insert(letter).second;
    });
    const Pattern sans = sans_of("");
    FcResult result = FcResultMatch;
    const Pattern usual(sans ? FcFontMatch(nullptr, sans.get(), &result) : nullptr, &FcPatternDestroy);
    if (usual) fonts.usual = face_of(usual.get());
    if (fonts.usual)
        taken_by(usual.get(), wanted);
    else
        std::erase_if(wanted, [](char32_t letter) { return letter < 0x100; });
    // Typefaces for that language first, most similar to the usual one.
    const Pattern near = sans_of(language);
    FcFontSet* const sorted = near && fonts.usual && !wanted.empty()
                                  ? FcFontSort(nullptr, near.get(), FcFalse, nullptr, &result)
                                  : nullptr;
    for (int k = 0; sorted && k < sorted->nfont && !wanted.empty(); ++k) {
        const auto face = face_of(sorted->fonts[k]);
        const Letters taken = face ? taken_by(sorted->fonts[k], wanted) : Letters();
        if (!taken.empty()) fonts.others.push_back({*face, utf8(taken)});
    }
    if (sorted) FcFontSetDestroy(sorted);
    wanted.merge(beyond);
    fonts.unwritten = utf8(wanted);
    return fonts;
}

std::string right_to_left_letters(const std::string& words) {
    Letters letters = letters_of(words);
    // The blocks from Hebrew to Arabic, and their presentation forms.
    std::erase_if(letters, [](char32_t letter) {
        const bool is_one = (letter >= 0x590 && letter <= 0x8FF) || (letter >= 0xFB1D && letter <= 0xFDFF) ||
                            (letter >= 0xFE70 && letter <= 0xFEFE);
        return !is_one;
    });
    return utf8(letters);
}

ImGuiLayer::ImGuiLayer(double scale, const std::string& words, const std::string& language)
    : context_(ImGui::CreateContext()), words_(words), fonts_(find_fonts(words, language)) {
    ImGui::SetCurrentContext(context_);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.LogFilename = nullptr;
    for (std::size_t k = 0; k < std::size(panel_keys); ++k)
        io.KeyMap[panel_keys[k].second] = static_cast<int>(k);
    set_scale(scale);
}

void ImGuiLayer::set_scale(double scale) {
    scale_ = scale;
    apply_theme(scale);
    set_fonts(fonts_, words_, scale);
}

ImGuiLayer::~ImGuiLayer() {
    ImGui::DestroyContext(context_);
}

void ImGuiLayer::begin(int width, int height, double seconds, std::span<const InputEvent> events) {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = ImVec2(static_cast<float>(width), static_cast<float>(height));
    io.DeltaTime = static_cast<float>(seconds > 1e-4 ? seconds : 1e-4);
    // ImGui samples buttons once per picture: a short click gets a picture for each half, and a pointer that
    // leaves with its release, as a finger's or a quick hand's, stays until the release.
    std::vector<InputEvent> now = std::exchange(later_, {});
    now.insert(now.end(), events.begin(), events.end());
    std::set<std::string> pressed;
    bool is_released = false;
    for (const InputEvent& event : now) {
        using Kind = InputEvent::Kind;
        const bool is_let_go = event.kind == Kind::released && pressed.contains(event.word),
                   goes = (event.kind == Kind::moved || event.kind == Kind::left_window) && is_released;
        if (is_let_go || goes || !later_.empty()) {
            later_.push_back(event);
            continue;
        }
        if (event.kind == Kind::pressed) pressed.insert(event.word);
        is_released = is_released || event.kind == Kind::released;
        tell(io, event);
    }
    ImGui::NewFrame();
    std::ranges::fill(io.KeysDown, false);  // a held key repeats as the keyboard says
}

void ImGuiLayer::end() {
    ImGui::Render();
}

std::uint64_t ImGuiLayer::hash() const {
    ByteHash hash;
    const auto add = [&hash](const auto& vector) {
        hash.add(vector.Data, static_cast<std::size_t>(vector.size_in_bytes()));
    };
    const ImDrawData* const drawn = ImGui::GetDrawData();
    for (int k = 0; drawn && k < drawn->CmdListsCount; ++k) {
        const ImDrawList& list = *drawn->CmdLists[k];
        add(list.VtxBuffer);
        add(list.IdxBuffer);
        for (const ImDrawCmd& command : list.CmdBuffer) hash.add(&command.ClipRect, sizeof(command.ClipRect));
    }
    return hash.value();
}

}  // namespace touchable
