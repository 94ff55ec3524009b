#pragma once

#include <string>
#include <vector>

#include "player/window/button_signs.hpp"
#include "player/window/panel_contents.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// A few large buttons for visitors of a kiosk, fit for fingers, in the middle of the picture's lower edge.
/// Sizes in pixels; `scale` as in ScreenSize.
class KioskBar {
public:
    /// Where it is, or would be: it keeps its place, whatever its buttons say.
    KioskBar(const PanelFacts& facts, float width, float height, float scale);
    float left() const { return left_; }
    float top() const { return top_; }
    float right() const { return right_; }
    float bottom() const { return bottom_; }

    /// Between ImGuiLayer's `begin` and `end`.
    void draw(std::vector<WindowCommand>& asked) const;

private:
    struct Button {
        const char* id;
        const std::string& words;
        ButtonSign sign;
        WindowCommand command;
        bool is_lit = false;          ///< what it switches is on
        bool is_there = true;         ///< otherwise it does nothing now
        const std::string& or_words;  ///< that it has at other times
    };
    static std::vector<Button> buttons_of(const PanelFacts& facts);
    void draw_button(const Button& button, const ImVec2& at, std::vector<WindowCommand>& asked) const;

    std::vector<Button> buttons_;
    float left_, top_, right_, bottom_;
    float wide_, high_, text_;  // of a button; of its words: 0: there is no room for any
    float gap_;
};

}  // namespace touchable
