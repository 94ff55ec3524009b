#pragma once

#include <span>
#include <string>
#include <vector>

#include "player/window/font_fallback.hpp"
#include "player/window/input_event.hpp"

struct ImGuiContext;

namespace touchable {

/// Dear ImGui: its input, and what it lays out, whoever draws it then (ImGuiVulkan). One at a time.
class ImGuiLayer {
public:
    /// `scale` as in ScreenSize. `words`: whose letters are there in both sizes, beside what the window says;
    /// `language` is theirs (find_fonts).
    explicit ImGuiLayer(double scale, const std::string& words = "", const std::string& language = "");
    ~ImGuiLayer();
    ImGuiLayer(const ImGuiLayer&) = delete;
    ImGuiLayer& operator=(const ImGuiLayer&) = delete;

    /// Which of `words` no typeface of this machine writes: UTF-8, each letter once.
    const std::string& unwritten() const { return fonts_.unwritten; }
    double scale() const { return scale_; }
    /// Between pictures. Whoever draws them needs the letters anew.
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
