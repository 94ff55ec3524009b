#pragma once

// The modes that every window has, in what the left button and keys do over the picture: the view that is
// turned, the list of clips, the measure, and the brush of materials. As any mode they are asked by
// WindowCore (window_mode.hpp), and belong to the window's thread; these four may also be asked by name, by
// the commands of the table and by the parts that need the list or what the brush paints.

#include <cstdio>

#include "player/window/measure.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_brush.hpp"
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

/// The list of clips, and the place in it: a person goes through it by keys, and at the end of a clip that
/// does not repeat the window goes on by itself.
class PlaylistMode final : public WindowMode {
public:
    using WindowMode::WindowMode;

    const Playlist& list() const { return list_; }
    void set_list(Playlist list) { list_ = std::move(list); }
    /// One on, or back.
    void go(int by);
    /// From the clip's end to the next clip. A clip that is over in a blink rests first. The clip also stays
    /// while it is touched or painted, or something of the panel is dragged, and some seconds after that.
    void go_on(double now_s) override;
    void begin_clip(bool goes_on) override;
    void draw(PanelFacts& facts, const Seen&) override { facts.clips = list_.size(); }

private:
    bool is_touched() const;

    Playlist list_;                    // of the clip that is there
    std::optional<double> went_on_s_;  // to the next clip by itself, or tried to: at this end
    double shown_s_ = 0;               // since when the clip is
    std::optional<double> touched_s_;  // when a clip was last touched, painted or measured
};

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
