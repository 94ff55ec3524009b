#pragma once

// A mode of the window: one thing that a window can be used for beside showing a clip and touching it. There
// are a kiosk for visitors, a study in it, the list of clips, the measure, the view that dragging turns, and
// the brush of materials.
//
// WindowCore holds the modes in one list. What comes goes through it in order, until one mode takes it, and
// then to the core: an event (`handle`), what the pointer does over the picture (`handle_pointer`), a command
// (`handle`), a wish to close what is in front (`leave`). In a turn all modes `look` at the clip's moment,
// `tick` once events are taken, and `go_on` once the panel's commands are, too. For a picture all modes
// `prepare` it before fingers are led, and `draw` what they show beside it. What another part has to know of
// the modes is a question with a plain default, which WindowCore::any asks all of them. The list, the
// measure, the view and the brush may also be asked by name; a kiosk or a study only by these questions.
//
// A mode belongs to the window's thread, and to its core, which outlives it. Nothing here waits but `close`
// and `finish`.

#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/view.hpp"
#include "player/session/touch_setup.hpp"
#include "player/window/input_event.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/screen.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

class OpenedClip;
class WindowCore;

/// What a left button does that is pressed over the picture.
enum class LeftButton {
    touches,     ///< it presses the finger
    is_a_tool,   ///< it is a mode's
    turns_view,  ///< as the middle button does
};

class WindowMode : NonCopyable {
public:
    explicit WindowMode(WindowCore& core) : core_(core) {}
    virtual ~WindowMode() = default;

    // What comes. Whether the mode takes it, and it goes no further.
    virtual bool handle(const InputEvent&) { return false; }
    /// An event of the pointer, or of a touch that stands for it. `is_of_panel`: the panel has it.
    virtual bool handle_pointer(const InputEvent&, bool /*is_of_panel*/) { return false; }
    virtual bool handle(const WindowCommand&) { return false; }
    /// Closes what the mode has in front of the picture; whether there was anything.
    virtual bool leave() { return false; }
    /// Another mode takes the left button.
    virtual void put_away() {}

    // A turn, with a clip; `look` also before the first picture. Seconds of WindowTime::now_s.
    virtual void look(const WatchedMoment&) {}
    virtual void tick(double /*now_s*/) {}
    virtual void go_on(double /*now_s*/) {}

    /// What a picture shows.
    struct Seen {
        const WatchedMoment& moment;
        const HeightField& field;
        const ViewCamera& camera;  ///< of the window's size
    };
    virtual void prepare(const Seen&) {}
    virtual void draw(PanelFacts&, const Seen&) {}

    /// The window's parts are there, and no clip yet.
    virtual void begin() {}
    /// Refuses the first clip.
    virtual Result<void> check(const OpenedClip&) const { return {}; }
    /// Another clip is there. `goes_on`: it is seen as the one before was.
    virtual void begin_clip(bool /*goes_on*/) {}
    /// All is as it was at the start, for the next visitor.
    virtual void begin_anew() {}
    /// Something went wrong, in the words that a person reads.
    virtual void note_fault(const std::string&) {}
    /// The window ends, by `ended`: the hand has no power any more, and the clip goes on.
    virtual void close(const Result<void>& /*ended*/) {}
    /// The clip has ended: completes what the mode keeps.
    virtual Result<void> finish() { return {}; }

    // Questions.
    virtual LeftButton left_button() const { return LeftButton::touches; }
    /// Only visitors see the window: it says nothing to them, and has to go on by itself.
    virtual bool is_unattended() const { return false; }
    /// The next input of a script waits.
    virtual bool is_at_work() const { return false; }
    /// The picture moves without an input, and the finger touches without a person.
    virtual bool moves_by_itself() const { return false; }
    /// The clip begins again at its end.
    virtual bool repeats_clip() const { return false; }
    /// The view and the colours of a clip are those of the next one, too.
    virtual bool keeps_view() const { return false; }
    /// The mode says which clip is shown: neither its end nor a fault leads to another one.
    virtual bool chooses_clip() const { return false; }
    /// The session must not be replaced by another one now.
    virtual bool keeps_session() const { return false; }
    virtual bool hides_forces() const { return false; }
    /// What of the picture's height the mode needs below the clip, 0 to 1.
    virtual double strip_below(const ScreenSize&) const { return 0; }
    /// Letters that the window has to write, beside its own (UTF-8).
    virtual std::string letters() const { return {}; }
    /// What is to be kept and is not.
    virtual std::vector<Error> faults() const { return {}; }

protected:
    WindowCore& core_;
};

}  // namespace touchable
