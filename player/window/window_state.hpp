// SPDX-License-Identifier: Apache-2.0
#pragma once

// What all parts and modes of a window share: options, screen, sound, the current clip, messages, times.
//
// A part (WindowHand, WindowInput, WindowClips, WindowPicture) and a mode (window_mode.hpp) has the rest of
// its state to itself, and gets by its constructor the other parts that it uses. WindowCore owns them all,
// and WindowLoop runs them (window_loop.cpp). All of it belongs to the window's thread, the program's main
// thread.

#include <set>

#include "player/window/opened_clip.hpp"
#include "player/window/play_window.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_clock.hpp"
#include "player/window/window_files.hpp"
#include "player/window/window_mode.hpp"

namespace touchable {

/// A window's times.
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

class WindowState : NonCopyable {
public:
    explicit WindowState(PlayOptions wanted) : options(std::move(wanted)) {}

    PlayOptions options;  ///< change only while the first clip is opened
    WindowTime time;
    Notices notices;
    PlayFigures figures;
    SettingsFile settings_file;          ///< with the settings kept by the previous window
    std::unique_ptr<Screen> screen;      ///< set while the window opens
    std::unique_ptr<WindowSound> sound;  ///< set while the window opens
    BackgroundWriter screenshots{"screenshots", "pictures of the window", most_screenshots};
    /// The current clip; null before the first clip opens, never afterwards.
    std::unique_ptr<OpenedClip> clip;
    std::optional<PlaybackControl> playback;  ///< of the current clip
    std::vector<WindowMode*> modes;           ///< in order of priority

    /// Whether the question is true for any mode.
    bool any(bool (WindowMode::*question)() const) const {
        return std::ranges::any_of(modes, [question](const WindowMode* mode) { return (mode->*question)(); });
    }
    bool any_button(LeftButton use) const {
        return std::ranges::any_of(modes,
                                   [use](const WindowMode* mode) { return mode->left_button() == use; });
    }
    bool is_unattended() const { return any(&WindowMode::is_unattended); }
    /// Gives the left button to a mode: the others put away their tools.
    void take_button(const WindowMode& mode) {
        for (WindowMode* const other : modes)
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
        for (WindowMode* const mode : modes) mode->note_fault(fault);
    }
    /// Whether this file fault is new.
    bool is_new_fault(const Error& fault) { return file_faults_.insert(fault.message).second; }

    /// The user closes the window. The second time it does not wait for the brush.
    void close() { leaves_at_once_ = std::exchange(quits_, true); }
    void quit() { quits_ = true; }
    bool quits() const { return quits_; }
    bool leaves_at_once() const { return leaves_at_once_; }

private:
    std::set<std::string> told_, file_faults_;  // printed while unattended; file faults already reported
    bool quits_ = false, leaves_at_once_ = false;
};

/// Prints a warning on the terminal.
void warn_on_terminal(const std::string& words);

}  // namespace touchable
