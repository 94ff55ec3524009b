#pragma once

#include <optional>
#include <string>
#include <vector>

namespace touchable {

/// A typeface of the system.
struct FontFace {
    std::string file;  ///< TrueType or OpenType
    int index = 0;     ///< in that file, which may be a collection
    bool operator==(const FontFace&) const = default;
};

/// One that writes what the usual one cannot.
struct FallbackFont {
    FontFace face;
    std::string letters;  ///< UTF-8: those that are taken of it
};

/// Which of the system's typefaces write some words, as fontconfig knows them.
struct FontFallback {
    std::optional<FontFace> usual;     ///< sans serif; nothing: Dear ImGui's own, which has Latin-1
    std::vector<FallbackFont> others;  ///< each for letters that the usual one has not
    std::string unwritten;             ///< UTF-8: letters that no typeface has, each once
};

/// `words`: UTF-8. `language` ("ja"; empty: of whoever is logged in): of letters that the usual typeface
/// lacks its form is taken, as Chinese and Japanese write one letter in two ways. Letters beyond U+FFFF are
/// unwritten: Dear ImGui has none of them where its letters are of 16 bits, as in Debian.
FontFallback find_fonts(const std::string& words, const std::string& language = "");

/// The letters among `words` (UTF-8), each once, that are written from right to left, as Hebrew and Arabic
/// are.
std::string right_to_left_letters(const std::string& words);

}  // namespace touchable
