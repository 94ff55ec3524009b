#pragma once

// The core of a window: its parts, and what all of them and the modes share.
//
// The parts are: the screen, sound, the haptic device (WindowHand), pointer and touches (WindowInput),
// pictures and panels (WindowPicture), changing clips (WindowClips), and the modes (WindowMode). Each part is
// a class with its own state, and reaches the others through the core. The core itself holds the current clip
// and the messages, and dispatches events and commands through the modes.
//
// WindowLoop (window_loop.cpp) owns the core. Each turn it draws, if a picture is due; waits for input;
// handles the events, and those of a script; calls the modes' `tick`; takes the panel's commands; continues
// modes, input and clips; and reports files written or failed.
//
// All of this runs on the window's thread, the program's main thread. The screen's own thread calls only
// WindowHand::stop_at_once; clips are opened on a thread of WindowClips.

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

/// A window's times, shared by all its parts. The window's thread only.
struct WindowTime {
    const WindowClock::time_point asked_for = WindowClock::now();
    WindowClock::time_point last_event{};            ///< the last one that makes a picture due
    std::optional<WindowClock::time_point> begun{};  ///< at the first picture; offline at the first tick
    /// Time of scripts and of user input: stands still while the machine is suspended or stalled.
    double script_s = 0;
    double stirred_s = 0;  ///< `script_s` of the last user input

    /// Since the first picture; 0 before it.
    double now_s() const { return begun ? WindowClock::seconds_between(*begun, WindowClock::now()) : 0; }
    /// CPU time since the first picture, of this thread and of the process.
    double thread_cpu_ms() const { return begun ? cpu_ms(CLOCK_THREAD_CPUTIME_ID) - begun_thread_ms_ : 0; }
    double process_cpu_ms() const { return begun ? cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - begun_process_ms_ : 0; }
    void note_event() { last_event = WindowClock::now(); }
    /// Notes when the first picture was shown; returns the ms since the window was requested.
    double begin(WindowClock::time_point at) {
        begun = at;
        begun_thread_ms_ = cpu_ms(CLOCK_THREAD_CPUTIME_ID);
        begun_process_ms_ = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
        return 1000 * WindowClock::seconds_between(asked_for, at);
    }

private:
    static double cpu_ms(clockid_t clock) { return static_cast<double>(clock_ns(clock)) * 1e-6; }

    double begun_thread_ms_ = 0, begun_process_ms_ = 0;
};

class WindowCore : NonCopyable {
public:
    explicit WindowCore(PlayOptions wanted) : options(std::move(wanted)) {}
    /// On every exit path the hand is unpowered before anything is waited for.
    ~WindowCore() { hand_.power_off(); }

    /// Opens all parts, once, and requests the first clip. Call it before everything else.
    Result<void> open();

    // Data that all parts read and update. Options change only while the first clip is opened.
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
    /// The settings kept by the previous window.
    const SettingsFile& settings_file() const { return settings_file_; }
    /// Null before the first clip opens, never afterwards.
    OpenedClip* clip() { return clip_.get(); }
    /// The current clip's playback.
    PlaybackControl& playback() { return *playback_; }
    void set_clip(std::unique_ptr<OpenedClip> clip);

    // Modes, all in order of priority.
    const std::vector<WindowMode*>& modes() const { return modes_; }
    BrushMode& brush() { return brush_; }
    MeasureMode& measure() { return measure_; }
    PlaylistMode& playlist() { return playlist_; }
    ViewMode& view() { return view_; }
    /// Whether the question is true for any mode.
    bool any(bool (WindowMode::*question)() const) const {
        return std::ranges::any_of(modes_,
                                   [question](const WindowMode* mode) { return (mode->*question)(); });
    }
    bool any_button(LeftButton use) const {
        return std::ranges::any_of(modes_,
                                   [use](const WindowMode* mode) { return mode->left_button() == use; });
    }
    bool is_unattended() const { return any(&WindowMode::is_unattended); }
    /// Gives the left button to a mode: the others put away their tools.
    void take_button(const WindowMode& mode) {
        for (WindowMode* const other : modes_)
            if (other != &mode) other->put_away();
    }

    // Messages: in the window, and on the terminal if no user sees the window.
    void say(std::string words, Tone tone = Tone::remark, About about = About::window) {
        if (tone == Tone::fault) note_fault(words);
        if (tone != Tone::remark) tell(words);
        notices.say(std::move(words), tone, time.script_s, about);
        time.note_event();
    }
    /// A refusal or a fault.
    void say(const Error& error) {
        say(error.message, error.kind == ErrorKind::usage ? Tone::refusal : Tone::fault);
    }
    void say(const Result<void>& done) {
        if (!done) say(done.error());
    }
    /// Prints a fault on the terminal if headless or unattended; unattended, each message once, 100 at most.
    void tell(const std::string& fault);
    /// Whether an unattended window printed it.
    bool is_told(const std::string& fault) const { return told_.contains(fault); }
    /// Passes a fault to the modes, which may log it.
    void note_fault(const std::string& fault) {
        for (WindowMode* const mode : modes_) mode->note_fault(fault);
    }
    /// Whether this file fault is new.
    bool is_new_fault(const Error& fault) { return file_faults_.insert(fault.message).second; }

    // Input.
    void take(const InputEvent& event);
    void take(const WindowCommand& command);
    /// Leaves the frontmost item; if there is none, the window.
    void leave();
    /// The user closes the window. The second time it does not wait for the brush.
    void close() { leaves_at_once_ = std::exchange(quits_, true); }
    void quit() { quits_ = true; }
    bool quits() const { return quits_; }
    bool leaves_at_once() const { return leaves_at_once_; }

private:
    Result<void> open_mode();
    Result<void> open_screen(const KeptSettings& kept);

    // Parts are destroyed in the opposite order.
    WindowHand hand_{*this};
    std::unique_ptr<Screen> screen_;
    std::unique_ptr<WindowSound> sound_;
    BackgroundWriter screenshots_{"screenshots", "pictures of the window", most_screenshots};
    WindowPicture picture_{*this};
    WindowInput input_{*this};
    std::unique_ptr<OpenedClip> clip_;
    std::optional<PlaybackControl> playback_;
    SettingsFile settings_file_;
    std::set<std::string> told_, file_faults_;  // printed while unattended; file faults already reported
    bool quits_ = false, leaves_at_once_ = false;
    PlaylistMode playlist_{*this};
    MeasureMode measure_{*this};
    ViewMode view_{*this};
    BrushMode brush_{*this};
    std::unique_ptr<WindowMode> kiosk_;  // or a study; null: neither
    std::vector<WindowMode*> modes_{&playlist_, &measure_, &view_, &brush_};
    WindowClips clips_{*this};  // its thread ends before the data it uses
};

/// Prints a warning on the terminal.
void warn_on_terminal(const std::string& words);

}  // namespace touchable
