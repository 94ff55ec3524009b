#include "player/panel/font_fallback.hpp"

#include <fontconfig/fontconfig.h>
#include <imgui.h>

#include <memory>
#include <optional>
#include <set>

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
        if (taken <= 0) break;  // no UTF-8: whoever read the words refuses it
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

/// Of a kind that Dear ImGui reads: outlines of one colour.
std::optional<FontFace> face_of(FcPattern* font) {
    FcChar8* name = nullptr;
    if (FcPatternGetString(font, FC_FILE, 0, &name) != FcResultMatch || !name) return {};
    FcBool has_colours = FcFalse;
    if (FcPatternGetBool(font, FC_COLOR, 0, &has_colours) == FcResultMatch && has_colours) return {};
    const std::string file = reinterpret_cast<const char*>(name);
    if (!file.ends_with(".ttf") && !file.ends_with(".otf") && !file.ends_with(".ttc")) return {};
    int index = 0;
    FcPatternGetInteger(font, FC_INDEX, 0, &index);
    // Above 16 bits an index names an instance of a variable typeface: the file's own form does.
    return FontFace{file, index & 0xFFFF};
}

/// Those that a typeface has go from `wanted`, and are what is returned.
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
    // Typefaces name Chinese with a country.
    const std::string named = language == "zh" ? "zh-cn" : language;
    if (!named.empty())
        FcPatternAddString(wanted.get(), FC_LANG, reinterpret_cast<const FcChar8*>(named.c_str()));
    FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
    FcDefaultSubstitute(wanted.get());
    return wanted;
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
    if (fonts.usual) taken_by(usual.get(), wanted);
    // The nearest to the usual one first, of those for that language.
    const Pattern near = sans_of(language);
    const bool has_all = fonts.usual && wanted.empty();
    FcFontSet* const sorted =
        near && !has_all ? FcFontSort(nullptr, near.get(), FcTrue, nullptr, &result) : nullptr;
    for (int k = 0; sorted && k < sorted->nfont; ++k) {
        const auto face = face_of(sorted->fonts[k]);
        if (!face) continue;
        const Letters taken = taken_by(sorted->fonts[k], wanted);
        if (!fonts.usual)
            fonts.usual = face;
        else if (!taken.empty())
            fonts.others.push_back({*face, utf8(taken)});
    }
    if (sorted) FcFontSetDestroy(sorted);
    if (!fonts.usual) std::erase_if(wanted, [](char32_t letter) { return letter < 0x100; });
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

}  // namespace touchable
