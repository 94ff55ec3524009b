#pragma once

#include "player/window/window_mode.hpp"

namespace touchable {

/// From where the clip is seen: keys and dragging turn the view.
class ViewMode final : public WindowMode {
public:
    using WindowMode::WindowMode;

    /// The clip's own view; dragging touches again.
    void go_home();
    /// Dragging turns the view, or presses the finger again.
    void turn_or_touch();

    bool leave() override { return std::exchange(is_turning_, false); }
    void put_away() override { is_turning_ = false; }
    void begin_anew() override { go_home(); }
    void begin_clip(bool goes_on) override { is_turning_ = is_turning_ && goes_on; }
    void draw(PanelFacts& facts, const Seen&) override { facts.is_turning = is_turning_; }
    LeftButton left_button() const override {
        return is_turning_ ? LeftButton::turns_view : LeftButton::touches;
    }

private:
    bool is_turning_ = false;
};

}  // namespace touchable
