// SPDX-License-Identifier: Apache-2.0
#pragma once

// A mode of the window: one use of a window besides showing a clip and touching it. The modes are a kiosk for
// visitors, a study in it, the list of clips, the measure, turning the view by dragging, and the brush of
// materials.
//
// WindowState holds the modes in one list. Input passes through it in order, until one mode takes it, and
// then to the window: an event (`handle`), a pointer action over the picture (`handle_pointer`), a command
// (`handle`), a request to close the frontmost item (`leave`). In a turn all modes `look` at the clip's
// moment, `tick` after events, and `go_on` after the panel's commands. For a picture all modes `prepare` it
// before fingers move, and `draw` what they show beside it. Other parts query the modes through functions
// with plain defaults, which WindowState::any calls on all of them. The list, the measure, the view and the
// brush may also be called by name; a kiosk or a study only by these queries.
//
// A mode belongs to the window's thread. Its window outlives it. Only `close` and `finish` wait.

#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/session/watched_session.hpp"
#include "player/view/view.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/screen.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

class OpenedClip;
class WindowState;

/// The effect of a left button pressed over the picture.
enum class LeftButton {
    touches,     ///< presses the finger
    is_a_tool,   ///< used by a mode
    turns_view,  ///< like the middle button
};

class WindowMode : NonCopyable {
public:
    explicit WindowMode(WindowState& window) : window_(window) {}
    virtual ~WindowMode() = default;

    // Input. Returns whether the mode takes it, so that it goes no further.
    virtual bool handle(const InputEvent&) { return false; }
    /// An event of the pointer, which is `at` that place of the window, or of a touch that stands for it.
    /// `is_of_panel`: the panel uses it.
    virtual bool handle_pointer(const InputEvent&, const glm::dvec2& /*at*/, bool /*is_of_panel*/) {
        return false;
    }
    virtual bool handle(const WindowCommand&) { return false; }
    /// Closes the mode's frontmost item; returns whether there was one.
    virtual bool leave() { return false; }
    /// Another mode takes the left button.
    virtual void put_away() {}

    // A turn, with a clip; `look` also before the first picture. Seconds of WindowTime::now_s.
    virtual void look(const WatchedMoment&) {}
    virtual void tick(double /*now_s*/) {}
    virtual void go_on(double /*now_s*/) {}

    /// The content of a picture.
    struct Seen {
        const WatchedMoment& moment;
        const HeightField& field;
        const ViewCamera& camera;  ///< of the window's size
    };
    virtual void prepare(const Seen&) {}
    virtual void draw(PanelFacts&, const Seen&) {}

    /// The window's parts exist, and no clip yet.
    virtual void begin() {}
    /// Returns an error to refuse the first clip.
    virtual Result<void> check(const OpenedClip&) const { return {}; }
    /// A new clip is shown. `goes_on`: with the previous view.
    virtual void begin_clip(bool /*goes_on*/) {}
    /// Resets to the start, for the next visitor.
    virtual void begin_anew() {}
    /// A fault occurred, in the words for the user.
    virtual void note_fault(const std::string&) {}
    /// The window ends with `ended`: the haptic device is powered down, and the clip still runs.
    virtual void close(const Result<void>& /*ended*/) {}
    /// The clip has ended: completes the mode's files.
    virtual Result<void> finish() { return {}; }

    // Queries.
    virtual LeftButton left_button() const { return LeftButton::touches; }
    /// Only visitors see the window: it shows them no messages, and has to continue by itself.
    virtual bool is_unattended() const { return false; }
    /// The next input of a script waits.
    virtual bool is_at_work() const { return false; }
    /// The picture moves without input, and the finger touches without a user.
    virtual bool moves_by_itself() const { return false; }
    /// The clip begins again at its end.
    virtual bool repeats_clip() const { return false; }
    /// The view and the colours carry over to the next clip.
    virtual bool keeps_view() const { return false; }
    /// The mode decides which clip is shown: neither its end nor a fault leads to another one.
    virtual bool chooses_clip() const { return false; }
    /// The session must not be replaced now.
    virtual bool keeps_session() const { return false; }
    virtual bool hides_forces() const { return false; }
    /// The share of the picture's height that the mode needs below the clip, 0 to 1.
    virtual double strip_below(const ScreenSize&) const { return 0; }
    /// Letters that the window needs besides its own (UTF-8).
    virtual std::string letters() const { return {}; }
    /// Faults of files that can no longer be written.
    virtual std::vector<Error> faults() const { return {}; }

protected:
    WindowState& window_;
};

}  // namespace touchable
