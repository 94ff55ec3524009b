#pragma once

#include "player/window/measure.hpp"
#include "player/window/window_mode.hpp"

namespace touchable {

/// The measure in a window: its command, its clicks over the picture, and its line, whose length is said, and
/// printed in the end.
class MeasureMode final : public WindowMode {
public:
    using WindowMode::WindowMode;

    void take(const WindowCommand& command);
    /// Takes the line and the tool away.
    void let_go() { tool_.let_go(); }

    bool handle_pointer(const InputEvent& event, bool is_of_panel) override;
    bool leave() override;
    void put_away() override { tool_.hold(false); }
    void prepare(const Seen& seen) override;
    void draw(PanelFacts& facts, const Seen& seen) override;
    void begin_clip(bool) override { let_go(); }
    void begin_anew() override { let_go(); }
    /// Prints all lines.
    Result<void> finish() override {
        for (const std::string& line : lines_) std::printf("%-24s%s\n", "measured", line.c_str());
        return {};
    }
    LeftButton left_button() const override {
        return tool_.is_held() ? LeftButton::is_a_tool : LeftButton::touches;
    }

private:
    MeasureTool tool_;
    std::vector<std::string> lines_;  // between two places, in words
};

}  // namespace touchable
