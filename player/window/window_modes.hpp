// SPDX-License-Identifier: Apache-2.0
#pragma once

// The modes that every window has, for the left button and keys over the picture: turning the view, the list
// of clips, the measure, and the brush of materials. As with any mode, the window calls them
// (window_mode.hpp) on its thread; these four may also be called by name, by commands of the table.

#include <cstdio>
#include <deque>

#include "engine/base/words.hpp"
#include "player/view/pointer.hpp"
#include "player/window/measure.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_brush.hpp"
#include "player/window/window_mode.hpp"

namespace touchable {

class ClipPicture;
class WindowClips;
class WindowInput;
class WindowPanel;

/// The clip's viewpoint: keys and dragging turn the view.
class ViewMode final : public WindowMode {
public:
    ViewMode(WindowState& window, WindowInput& input) : WindowMode(window), input_(input) {}

    /// The clip's own view; dragging touches again.
    void go_home();
    /// Dragging turns the view, or presses the finger again.
    void turn_or_touch();
    /// The view before the last gesture: a drag, or changes soon after each other.
    void undo();

    void go_on(double now_s) override;
    bool leave() override { return std::exchange(is_turning_, false); }
    void put_away() override { is_turning_ = false; }
    void begin_anew() override { go_home(); }
    void begin_clip(bool goes_on) override;
    void draw(PanelFacts& facts, const Seen&) override {
        facts.is_turning = is_turning_;
        facts.can_undo_view = !before_.empty();
    }
    LeftButton left_button() const override {
        return is_turning_ ? LeftButton::turns_view : LeftButton::touches;
    }

private:
    WindowInput& input_;
    bool is_turning_ = false;
    std::deque<WindowView::State> before_;  // the views before the last gestures, oldest first
    WindowView::State seen_;
    double changed_s_ = 0;
};

/// The list of clips (WindowClips::list): the user steps through it with keys, and at the end of a clip that
/// does not repeat the window continues by itself.
class PlaylistMode final : public WindowMode {
public:
    PlaylistMode(WindowState& window, const WindowPanel& panel, const WindowInput& input, WindowClips& clips)
        : WindowMode(window), panel_(panel), input_(input), clips_(clips) {}

    /// Steps forward or back.
    void go(int by);
    /// Goes to the next clip at the clip's end. A very short clip rests first. The clip also stays while it
    /// is touched or painted, or the panel is used, and some seconds after that.
    void go_on(double now_s) override;
    void begin_clip(bool goes_on) override;
    void draw(PanelFacts& facts, const Seen&) override;

private:
    bool is_touched() const;

    const WindowPanel& panel_;
    const WindowInput& input_;
    WindowClips& clips_;
    std::optional<double> went_on_s_;  // when it went on by itself, or tried to, at this end
    double shown_s_ = 0;               // when the clip was shown
    std::optional<double> touched_s_;  // when a clip was last touched, painted or measured
};

/// The measure in a window: its command, its clicks over the picture, and its line, whose length is shown,
/// and printed at the end.
class MeasureMode final : public WindowMode {
public:
    MeasureMode(WindowState& window, const WindowInput& input) : WindowMode(window), input_(input) {}

    void take(const WindowCommand& command);
    /// Removes the line and puts the tool away.
    void let_go() { tool_.let_go(); }

    bool handle_pointer(const InputEvent& event, const glm::dvec2& at, bool is_of_panel) override;
    bool leave() override;
    void put_away() override { tool_.hold(false); }
    void prepare(const Seen& seen) override;
    void draw(PanelFacts& facts, const Seen& seen) override;
    void begin_clip(bool) override { let_go(); }
    void begin_anew() override { let_go(); }
    /// Prints all lines.
    Result<void> finish() override {
        for (const std::string& line : lines_) std::printf("%-24s%s\n", "measured", one_line(line).c_str());
        return {};
    }
    LeftButton left_button() const override {
        return tool_.is_held() ? LeftButton::is_a_tool : LeftButton::touches;
    }

private:
    const WindowInput& input_;
    MeasureTool tool_;
    std::vector<std::string> lines_;  // completed measurements, as text
};

/// The brush of materials in a window: passes clips, commands and clicks to it, shows its messages, and makes
/// its materials seen, and felt through a change of settings.
class BrushMode final : public WindowMode {
public:
    BrushMode(WindowState& window, WindowPanel& panel, WindowClips& clips, ClipPicture& surface);

    void take(const WindowCommand& command);
    /// The brush, for queries.
    const WindowBrush& brush() const { return brush_; }
    /// The last call: completes its files, and prints their faults on the terminal. Fails if a requested save
    /// failed.
    Result<void> save();

    bool handle_pointer(const InputEvent& event, const glm::dvec2& at, bool is_of_panel) override;
    bool leave() override;
    void put_away() override { leave(); }
    void go_on(double now_s) override;
    void prepare(const Seen&) override;
    void draw(PanelFacts& facts, const Seen& seen) override;
    void begin_clip(bool goes_on) override;
    bool is_at_work() const override { return brush_.is_at_work(); }
    LeftButton left_button() const override {
        return brush_.is_held() ? LeftButton::is_a_tool : LeftButton::touches;
    }

private:
    void take_news();

    WindowPanel& panel_;
    WindowClips& clips_;
    ClipPicture& surface_;
    WindowBrush brush_;
};

}  // namespace touchable
