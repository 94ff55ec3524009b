#pragma once

struct ImGuiContext;

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "player/window/input_event.hpp"

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

/// `words`: UTF-8. `language` ("ja"; empty: of the person who is logged in): of letters that the usual
/// typeface lacks its form is taken, as Chinese and Japanese write one letter in two ways. Letters beyond
/// U+FFFF are unwritten: Dear ImGui has none of them where its letters are of 16 bits, as in Debian.
FontFallback find_fonts(const std::string& words, const std::string& language = "");

/// The letters among `words` (UTF-8), each once, that are written from right to left, as Hebrew and Arabic
/// are.
std::string right_to_left_letters(const std::string& words);

/// Dear ImGui: its input, and what it lays out for a painter (ImGuiVulkan). One at a time.
class ImGuiLayer : NonCopyable {
public:
    /// `scale` as in ScreenSize. `words`: whose letters are there in both sizes, beside what the window says;
    /// `language` is theirs (find_fonts).
    explicit ImGuiLayer(double scale, const std::string& words = "", const std::string& language = "");
    ~ImGuiLayer();

    /// Which of `words` no typeface of this machine writes: UTF-8, each letter once.
    const std::string& unwritten() const { return fonts_.unwritten; }
    double scale() const { return scale_; }
    /// Between pictures. Graphics need the letters anew afterwards (take_letters).
    void set_scale(double scale);
    /// Begins a picture of so many pixels, `seconds` after the one before; from here to `end` ImGui's calls
    /// make it.
    void begin(int width, int height, double seconds, std::span<const InputEvent> events);
    void end();
    /// Whether something of the panel is being pressed or dragged at the moment.
    bool holds_pointer() const;

private:
    ImGuiContext* context_;
    std::string words_;
    FontFallback fonts_;
    double scale_;
    // What came after a button that was let go in the picture it was pressed in.
    std::vector<InputEvent> later_;
};

}  // namespace touchable
