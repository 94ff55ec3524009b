#include "player/window/font_fallback.hpp"

#include <fontconfig/fontconfig.h>
#include <imgui.h>
#include <unistd.h>

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

/// Nothing: this process may not read it, or Dear ImGui cannot, which takes outlines of one colour.
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

/// Moves from `wanted` to what is returned the letters that a typeface has.
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
    if (fonts.usual)
        taken_by(usual.get(), wanted);
    else
        std::erase_if(wanted, [](char32_t letter) { return letter < 0x100; });
    // Typefaces for that language first, nearest to the usual one.
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

}  // namespace touchable
