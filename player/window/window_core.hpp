#pragma once

// The core of a window: its parts, and what all of them and the modes need.
//
// The parts are: the screen, sound, what gives forces (WindowHand), pointer and touches (WindowInput),
// pictures and panels (WindowPicture), clips that come and go (WindowClips), and the modes (WindowMode). Each
// part is a class of its own with its own state; what it wants of another it asks by the core. The core
// itself knows the clip that is there, what was said, and the way of an event and of a command through the
// modes.
//
// WindowLoop (window_loop.cpp) owns the core, and does this in each turn: it draws, if a picture is due;
// waits for input; handles the events, and those of a script; lets the modes tick; takes the panel's
// commands; lets modes, input and clips go on; and notes what became of files.
//
// All of this is the window's thread, which is the program's main thread. The screen's own thread calls
// WindowHand::stop_at_once, and nothing else; clips are opened on a thread of WindowClips.

#include <set>

#include "player/window/opened_clip.hpp"
#include "player/window/play_window.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_clips.hpp"
#include "player/window/window_clock.hpp"
#include "player/window/window_hand.hpp"
#include "player/window/window_input.hpp"
#include "player/window/window_modes.hpp"
#include "player/window/window_picture.hpp"

namespace touchable {

class WindowCore : NonCopyable {
public:
    explicit WindowCore(PlayOptions wanted) : options(std::move(wanted)) {}
    /// On every exit path the hand is unpowered before anything is waited for.
    ~WindowCore() { hand_.power_off(); }

    /// Opens all parts, once, and asks for the first clip. The rest may be called only afterwards.
    Result<void> open();

    // What all parts read, and tell. Options change only while the first clip is opened.
    PlayOptions options;
    WindowTime time;
    Notices notices;
    PlayFigures figures;

    // Parts.
    Screen& screen() { return *screen_; }
    WindowSound& sound() { return *sound_; }
    WindowHand& hand() { return hand_; }
    WindowInput& input() { return input_; }
    WindowPicture& picture() { return picture_; }
    WindowClips& clips() { return clips_; }
    BackgroundWriter& screenshots() { return screenshots_; }
    /// The settings that were kept by the window before.
    const SettingsFile& settings_file() const { return settings_file_; }
    /// Null: there is none yet. Once there is one, there is always one.
    OpenedClip* clip() { return clip_.get(); }
    /// Of the clip that is there.
    PlaybackControl& playback() { return *playback_; }
    void set_clip(std::unique_ptr<OpenedClip> clip);

    // Modes, all in their order.
    const std::vector<WindowMode*>& modes() const { return modes_; }
    BrushMode& brush() { return brush_; }
    MeasureMode& measure() { return measure_; }
    PlaylistMode& playlist() { return playlist_; }
    ViewMode& view() { return view_; }
    /// Whether the answer of any mode to a question is yes.
    bool any(bool (WindowMode::*question)() const) const {
        return std::ranges::any_of(modes_,
                                   [question](const WindowMode* mode) { return (mode->*question)(); });
    }
    bool any_button(LeftButton use) const {
        return std::ranges::any_of(modes_,
                                   [use](const WindowMode* mode) { return mode->left_button() == use; });
    }
    bool is_unattended() const { return any(&WindowMode::is_unattended); }
    /// The left button is that mode's: the others put away what they have.
    void take_button(const WindowMode& mode) {
        for (WindowMode* const other : modes_)
            if (other != &mode) other->put_away();
    }

    // What is said: in the window, and where no person sees that, on the terminal.
    void say(std::string words, Tone tone = Tone::remark, About about = About::window) {
        if (tone == Tone::fault) note_fault(words);
        if (tone != Tone::remark) tell(words);
        notices.say(std::move(words), tone, time.script_s, about);
        time.note_event();
    }
    /// What was refused, or went wrong.
    void say(const Error& error) {
        say(error.message, error.kind == ErrorKind::usage ? Tone::refusal : Tone::fault);
    }
    void say(const Result<void>& done) {
        if (!done) say(done.error());
    }
    /// On the terminal: where no window is seen, and where visitors cannot mend it; there each message once.
    void tell(const std::string& fault);
    /// Whether it was said there, of a window that is unattended.
    bool is_told(const std::string& fault) const { return told_.contains(fault); }
    /// To the modes, which may keep it.
    void note_fault(const std::string& fault) {
        for (WindowMode* const mode : modes_) mode->note_fault(fault);
    }
    /// Whether this fault of a file was not yet met.
    bool is_new_fault(const Error& fault) { return file_faults_.insert(fault.message).second; }

    // What comes.
    void take(const InputEvent& event);
    void take(const WindowCommand& command);
    /// Leaves what is in front, from front to back; where nothing is, the window.
    void leave();
    /// A person closes the window. The second time it does not wait for the brush.
    void close() { leaves_at_once_ = std::exchange(quits_, true); }
    void quit() { quits_ = true; }
    bool quits() const { return quits_; }
    bool leaves_at_once() const { return leaves_at_once_; }

private:
    Result<void> open_mode();
    Result<void> open_screen(const KeptSettings& kept);

    // Parts end in the opposite order.
    WindowHand hand_{*this};
    std::unique_ptr<Screen> screen_;
    std::unique_ptr<WindowSound> sound_;
    BackgroundWriter screenshots_{"screenshots", "pictures of the window", most_screenshots};
    WindowPicture picture_{*this};
    WindowInput input_{*this};
    std::unique_ptr<OpenedClip> clip_;
    std::optional<PlaybackControl> playback_;
    SettingsFile settings_file_;
    std::set<std::string> told_, file_faults_;  // on the terminal, unattended; that were said
    bool quits_ = false, leaves_at_once_ = false;
    PlaylistMode playlist_{*this};
    MeasureMode measure_{*this};
    ViewMode view_{*this};
    BrushMode brush_{*this};
    std::unique_ptr<WindowMode> kiosk_;  // or a study; null: neither
    std::vector<WindowMode*> modes_{&playlist_, &measure_, &view_, &brush_};
    WindowClips clips_{*this};  // its thread ends before what it works on
};

/// On the terminal.
void warn_on_terminal(const std::string& words);

}  // namespace touchable
