#pragma once

#include "player/window/window_brush.hpp"
#include "player/window/window_mode.hpp"

namespace touchable {

/// The brush of materials in a window: hands it clips, commands and clicks, says what it says, and lets what
/// it painted be felt, by the road of other settings.
class BrushMode final : public WindowMode {
public:
    explicit BrushMode(WindowCore& core);

    void take(const WindowCommand& command);
    /// The brush itself, to be asked.
    const WindowBrush& brush() const { return brush_; }
    /// The last call: completes its files, and says on the terminal what went wrong with them. Fails with why
    /// materials that were to be saved are not.
    Result<void> save();

    bool handle_pointer(const InputEvent& event, bool is_of_panel) override;
    bool leave() override;
    void put_away() override { leave(); }
    void go_on(double now_s) override;
    void draw(PanelFacts& facts, const Seen& seen) override;
    void begin_clip(bool goes_on) override;
    bool is_at_work() const override { return brush_.is_at_work(); }
    LeftButton left_button() const override {
        return brush_.is_held() ? LeftButton::is_a_tool : LeftButton::touches;
    }

private:
    void take_news();

    WindowBrush brush_;
};

}  // namespace touchable
