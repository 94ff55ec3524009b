// SPDX-License-Identifier: Apache-2.0
#pragma once

// The window: shows a clip, lets the user touch it, and ends when the user closes it.
//
// A program fills in PlayOptions and calls play_in_window, which returns its statistics (PlayFigures), or the
// error that ended the window. In between, the clip and its successors are opened, a session (player/session)
// computes forces of a haptic device or of the mouse, panels change settings, the brush changes materials,
// and recordings, sounds, films and pictures are written.
//
//     PlayOptions options;
//     options.session.clip.file = "globe.mkv";
//     options.screen.width = 1920;
//     const Result<PlayFigures> played = play_in_window(std::move(options));
//
// Variants: `kiosk` (unattended, loops, invites visitors), `study` (a kiosk whose visitors answer questions),
// `headless` (no window; needs `seconds`, `screenshot` or a script that quits), `script` (input at fixed
// moments).
//
// Threads: the main one calls play_in_window, which returns once the window is closed. It starts and ends the
// threads that it needs (screen, session, opening, files). A signal ends it too (player/run/terminal.hpp):
// the error is then of kind interrupted, and a haptic device is powered down before anything is waited for.
//
// The command line uses clips_of and own_settings_file (user_files.cpp) to fill in PlayOptions. Any thread
// may call them; they wait for the disk.

#include <map>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/scene/scene.hpp"
#include "player/audio/window_sound.hpp"
#include "player/draw/overlays.hpp"
#include "player/session/watched_session.hpp"
#include "player/window/kiosk.hpp"
#include "player/window/persistent_device.hpp"
#include "player/window/screen.hpp"
#include "player/window/study.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// The clips named by a path or a dropped file. A folder that is no clip itself stands for the clips in it
/// (videos, recordings, folders with a scene file), sorted by name with numbers in order: "clip2" before
/// "clip10". Any other name, and a folder without clips, stands for itself.
std::vector<std::filesystem::path> clips_of(const std::filesystem::path& named);

/// The user's play.json: in $XDG_CONFIG_HOME/touchable, otherwise in ~/.config/touchable.
Result<std::filesystem::path> own_settings_file();

/// A window's content, input devices, and output files.
struct PlayOptions {
    /// A window in a public place that runs unattended.
    struct Kiosk {
        KioskTimes times{};
        KioskTexts texts{};
        TouchedBy touched_by = TouchedBy::mouse;  ///< without a haptic device
        bool has_bar = true;                      ///< of large buttons; not in a study
        TouchLabels labels{};                     ///< of the first clip
        /// A spoken sound for each label, in the language of the texts; null: none.
        std::vector<std::shared_ptr<const SpokenSound>> label_sounds{};
        std::optional<std::filesystem::path> use_log{};  ///< UseLog; nullopt: none is kept
    };
    /// Texts for the terminal: the calling program's names of output files and guessed values.
    struct Names {
        std::string record = "the recording", sound = "the sound", video = "the film",
                    screenshot = "the picture";
        std::string (*remark)(const Remark&) = remark_in_words;
        /// Reports that a clip's materials were saved in `file`, and the command that makes a clip of both.
        std::string (*saved)(const std::string& clip, const std::string& file) =
            [](const std::string&, const std::string& file) { return "saved as " + file; };
        /// The command that makes a clip of this relief (settings_in_effect); empty: unknown.
        std::string (*relief)(const std::string& clip, const std::map<std::string, std::string>& in_effect) =
            [](const std::string&, const std::map<std::string, std::string>&) { return std::string(); };
        /// The command that converts the clip for faster reading; empty: unknown.
        std::string (*faster)(const std::string& clip) = [](const std::string&) { return std::string(); };
        std::string (*error)(const Error&) = [](const Error& of) { return of.message; };
    };

    SessionOptions session;
    std::shared_ptr<PersistentDevice> hand{};  ///< moves the fingers; null: the mouse does
    std::vector<ClipChoice> next_clips{};      ///< after the session's, in order
    /// Without any clip that can be opened, an empty window stays and gives the reason.
    bool stays_without_clip = false;
    ScreenOptions screen;
    bool headless = false;
    std::optional<double> scale{};  ///< of text and bars; nullopt: the display's
    /// Makes a screen instead of GLFW's or the headless one, for tests.
    std::function<std::unique_ptr<Screen>(const ScreenOptions&)> make_screen{};
    /// The clips in a dropped file or folder; tests replace it to simulate a disk that does not answer.
    std::function<std::vector<std::filesystem::path>(const std::filesystem::path&)> clips_of =
        touchable::clips_of;
    std::optional<Kiosk> kiosk{};           ///< loops and keeps no settings
    std::optional<Study> study{};           ///< for a kiosk: its visitors are the participants
    std::filesystem::path study_results{};  ///< a folder
    std::shared_ptr<TouchMeter> meter{};    ///< set by the window: the study's measurements
    std::shared_ptr<RunGpu> gpu{};          ///< draws; null: the window opens one
    std::string painter = "auto";           ///< auto, cpu, raster or mesh
    std::vector<ScriptedInput> script;
    std::optional<std::filesystem::path> screenshot;  ///< of the window, taken last before it closes
    double screenshot_s = 3;                          ///< a program's default of `seconds` for it
    std::optional<double> seconds;                    ///< until the window closes
    std::optional<double> most_newtons;               ///< limit for any finger, whatever the settings
    std::optional<std::filesystem::path> record;
    std::optional<std::filesystem::path> sound;  ///< a WAV file of the audible sound
    bool rumble = false;                         ///< a gamepad rumbles with contacts; not if `headless`
    std::optional<std::filesystem::path> video;  ///< a film of the window (FilmWriter)
    /// Whether that film is drawn offline, in the window's virtual time: each picture at its time, none left
    /// out, and the same bytes on each run. A camera and a haptic device keep the time of the clock.
    bool is_offline() const { return headless && video && !hand && !session.clip.is_camera(); }
    /// Of such a film: pictures a second, samples along a pixel's side (1, 2 or 4), and whether bars and
    /// words are shown from the start.
    struct Offline {
        int rate = FilmWriter::usual_rate, samples = 2;
        bool has_words = false;
    } film{};
    Existing existing = Existing::keep;
    Names names{};
    std::optional<std::filesystem::path> settings_file;  ///< nullopt: settings are not kept
    std::optional<std::filesystem::path>
        segments;  ///< file of the clip's segments and their materials, at first
    /// Folder for keeping a brush's changes between windows (BrushFiles); nullopt: they are not kept.
    std::optional<std::filesystem::path> brush_history;
    std::optional<bool> dent;  ///< whether dents are drawn; nullopt: as in the kept settings
    std::optional<Lighting> light;  ///< on the clip's colours; nullopt: as in the kept settings
    /// The user stated the size in `screen` (the kept size is ignored), or the filters in `session.clip` (the
    /// kept sets A and B are not used).
    bool size_is_stated = false, filters_are_stated = false;
};

/// Statistics and measurements of a window.
struct PlayFigures {
    std::int64_t pictures = 0;
    double seconds = 0;
    TimeSpread draw_ms, input_to_picture_ms;
    /// For pictures of a new frame: time for the surface, from codes to pixels; for texts, bars and curves;
    /// and until the finished picture is shown.
    TimeSpread surface_ms, words_ms, shown_ms;
    std::int64_t frames_due = 0, frames_in_time = 0;  ///< FramesShown, of all clips
    double first_picture_ms = 0;                      ///< since the window was requested
    /// CPU time since the first picture, of the drawing thread and of the process.
    double window_cpu_ms = 0, process_cpu_ms = 0;
    double least_detail = 1;  ///< PictureGovernor's
    std::int64_t film_pictures = 0, film_left_out = 0;
    WatchedFigures sessions{};  ///< the last one's, with the counts of all; no builder: there was no clip
    std::string painter, gpu;   ///< gpu: that draws; empty: none
    std::string sound_fault;            ///< the first fault of a clip's sound; empty: none
    std::string slow_reading;           ///< the first clip whose pictures are read too slowly; empty: none
    std::string relief;                 ///< command that makes a clip of the relief felt at the end; empty:
                                        ///< none
    std::string materials;              ///< unsaved painted materials; empty: none
};

/// Shows a clip in a window and lets the user touch it, until the window is closed. Main thread only.
Result<PlayFigures> play_in_window(PlayOptions options);

/// Whether the machine has a touch screen: a Linux input device on a display that reports several fingers.
/// `inputs`: the kernel's folder of input devices.
bool has_touch_screen(const std::filesystem::path& inputs = "/sys/class/input");

}  // namespace touchable
