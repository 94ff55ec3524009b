// SPDX-License-Identifier: Apache-2.0
#pragma once

struct ImGuiContext;

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "player/view/pointer.hpp"

namespace touchable {

/// A typeface of the system.
struct FontFace {
    std::string file;  ///< TrueType or OpenType
    int index = 0;     ///< index within a collection file
    bool operator==(const FontFace&) const = default;
};

/// A typeface with letters that the usual one lacks.
struct FallbackFont {
    FontFace face;
    std::string letters;  ///< UTF-8: the letters taken from it
};

/// The system's typefaces for a text, from fontconfig.
struct FontFallback {
    std::optional<FontFace> usual;     ///< sans serif; nullopt: Dear ImGui's own, which has Latin-1
    std::vector<FallbackFont> others;  ///< each for letters that the usual one lacks
    std::string unwritten;             ///< UTF-8: letters that no typeface has, each once
};

/// `words`: UTF-8. `language` ("ja"; empty: the logged-in user's) selects the form of letters that the usual
/// typeface lacks, as Chinese and Japanese write one letter in two ways. Letters beyond U+FFFF are unwritten,
/// as Dear ImGui with 16-bit letters, as in Debian, has none of them.
FontFallback find_fonts(const std::string& words, const std::string& language = "");

/// The letters among `words` (UTF-8), each once, that are written from right to left, as Hebrew and Arabic
/// are.
std::string right_to_left_letters(const std::string& words);

/// Dear ImGui's context: takes input, and prepares draw data for a renderer (ImGuiVulkan). One at a time.
class ImGuiLayer : NonCopyable {
public:
    /// `scale` as in ScreenSize. `words`: texts whose letters are loaded in both sizes, besides the window's
    /// own; `language` is theirs (find_fonts).
    explicit ImGuiLayer(double scale, const std::string& words = "", const std::string& language = "");
    ~ImGuiLayer();

    /// The letters of `words` that no typeface of this machine has: UTF-8, each once.
    const std::string& unwritten() const { return fonts_.unwritten; }
    double scale() const { return scale_; }
    /// Call between pictures. Graphics must then reload the font (take_letters).
    void set_scale(double scale);
    /// Begins a picture of that size, `seconds` after the previous one; ImGui calls up to `end` build it.
    void begin(int width, int height, double seconds, std::span<const InputEvent> events);
    void end();
    /// Of the draw data that `end` made: equal ones make the same picture.
    std::uint64_t hash() const;

private:
    ImGuiContext* context_;
    std::string words_;
    FontFallback fonts_;
    double scale_ = 1;
    // Events after a button release that came in the same picture as its press.
    std::vector<InputEvent> later_;
};

}  // namespace touchable
