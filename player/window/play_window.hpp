#pragma once

// The window: shows a clip, lets a person touch it, and ends when the person closes it.
//
// A program fills in PlayOptions and calls play_in_window, which returns what was counted (PlayFigures), or
// the error that ended the window. Everything else happens in between: the clip and the clips after it are
// opened, a session (player/session) computes forces of a held device or of the mouse, panels change
// settings, the brush changes materials, and recordings, sounds, films and pictures are written.
//
//     PlayOptions options;
//     options.session.clip.file = "globe.mkv";
//     options.screen.width = 1920;
//     const Result<PlayFigures> played = play_in_window(std::move(options));
//
// Variants: `kiosk` (unattended, loops, asks visitors to touch), `study` (a kiosk whose visitors answer
// questions), `headless` (no window; needs `seconds`, `screenshot` or a script that quits), `script` (input
// at fixed moments).
//
// play_in_window is called by the main thread and returns once the window is closed. It starts the threads
// that it needs (screen, session, opening, files) and ends them. A signal ends it, too
// (player/run/terminal.hpp): the error then is of kind interrupted, and a held device is without power
// before anything is waited for.
//
// clips_of and own_settings_file (user_files.cpp) are for the command line, which fills in
// PlayOptions by them. Any thread may call them; they wait for the disk.

#include <map>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"
#include "player/audio/window_sound.hpp"
#include "player/session/touch_setup.hpp"
#include "player/window/kiosk.hpp"
#include "player/window/persistent_device.hpp"
#include "player/window/screen.hpp"
#include "player/window/study.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// A window in a public place that runs unattended.
struct KioskOptions {
    KioskTimes times{};
    KioskTexts texts{};
    TouchedBy touched_by = TouchedBy::mouse;  ///< where no device is held
    bool has_bar = true;                      ///< of large buttons; not of a study
    TouchLabels labels{};                     ///< of the first clip
    /// A spoken sound for each label, in the language of the texts; null: none.
    std::vector<std::shared_ptr<const SpokenSound>> label_sounds{};
    std::optional<std::filesystem::path> use_log{};  ///< UseLog; nothing: none is kept
};

/// The clips that a word or a dropped file stands for. A folder that is no clip itself stands for the clips
/// in it (videos, recordings, folders with a scene file), by name, with numbers in their order: "clip2"
/// before "clip10". Any other name, and a folder without clips, stands for itself.
std::vector<std::filesystem::path> clips_of(const std::filesystem::path& named);

/// play.json of this person: in $XDG_CONFIG_HOME/touchable, otherwise in ~/.config/touchable.
Result<std::filesystem::path> own_settings_file();

/// What a window shows, how it is touched, and which files are written.
struct PlayOptions {
    /// Texts for the terminal: how the program that opened the window calls output files and guessed values.
    struct Names {
        std::string record = "the recording", sound = "the sound", video = "the film",
                    screenshot = "the picture";
        std::string (*remark)(const Remark&) = remark_in_words;
        /// Says that a clip's materials are in `file` now, and which command makes a clip of both.
        std::string (*saved)(const std::string& clip, const std::string& file) =
            [](const std::string&, const std::string& file) { return "saved as " + file; };
        /// The command that makes a clip of relief by these settings (settings_in_effect); empty: unknown.
        std::string (*relief)(const std::string& clip, const std::map<std::string, std::string>& in_effect) =
            [](const std::string&, const std::map<std::string, std::string>&) { return std::string(); };
        /// The command that makes a clip of it that is read faster; empty: unknown.
        std::string (*faster)(const std::string& clip) = [](const std::string&) { return std::string(); };
        std::string (*error)(const Error&) = [](const Error& of) { return of.message; };
    };

    SessionOptions session;
    std::shared_ptr<PersistentDevice> hand{};  ///< leads the fingers; nothing: the mouse does
    std::vector<ClipChoice> next_clips{};      ///< after the session's, in their order
    /// Where none of the clips can be opened, an empty window stays and says why.
    bool stays_without_clip = false;
    ScreenOptions screen;
    bool headless = false;
    std::optional<double> scale{};  ///< of words and bars; nothing: the display's
    /// Makes a screen in place of GLFW's or the headless one, such as a test's.
    std::function<std::unique_ptr<Screen>(const ScreenOptions&)> make_screen{};
    /// The clips in a dropped file or folder; a test puts a disk in its place that does not answer.
    std::function<std::vector<std::filesystem::path>(const std::filesystem::path&)> clips_of =
        touchable::clips_of;
    std::optional<KioskOptions> kiosk{};    ///< it loops and keeps no settings
    std::optional<Study> study{};           ///< of a kiosk: its visitors are the participants
    std::filesystem::path study_results{};  ///< a folder
    std::shared_ptr<TouchMeter> meter{};    ///< the window's own: measures what its study wants
    std::shared_ptr<RunGpu> gpu{};          ///< draws; nothing: the window opens one
    std::string painter = "auto";           ///< auto, cpu, raster or mesh
    std::vector<ScriptedInput> script;
    std::optional<std::filesystem::path> screenshot;  ///< of the window, the last thing done before it closes
    double screenshot_s = 3;             ///< the default of `seconds` that a program may take for it
    std::optional<double> seconds;       ///< after which the window closes
    std::optional<double> most_newtons;  ///< limit for any finger, whatever settings are chosen
    std::optional<std::filesystem::path> record;
    std::optional<std::filesystem::path> sound;  ///< a WAV file of what is heard
    bool rumble = false;  ///< a gamepad rumbles by what is felt; not where it is `headless`
    std::optional<std::filesystem::path> video;  ///< a film of what the window shows (FilmWriter)
    Existing existing = Existing::keep;
    Names names{};
    std::optional<std::filesystem::path> settings_file;  ///< nothing: settings are not kept
    std::optional<std::filesystem::path>
        segments;  ///< file of the clip's segments and their materials, at first
    /// Folder in which changes by a brush last from window to window (BrushFiles); nothing: they do not.
    std::optional<std::filesystem::path> brush_history;
    std::optional<bool> dent;  ///< whether a surface that gives way is drawn so; nothing: as it is kept
    /// A person gave the size in `screen` (the last window's is ignored), or the filters in `session.clip`
    /// (kept sets A and B stay as they are).
    bool size_is_stated = false, filters_are_stated = false;
};

/// What was counted and measured while the window was open.
struct PlayFigures {
    /// The newest of many values: a window may be open for days.
    class NewestValues {
    public:
        void add(double value) {
            if (values_.size() < most)
                values_.push_back(value);
            else
                values_[next_++ % most] = value;
        }
        const std::vector<double>& values() const { return values_; }

    private:
        static constexpr std::size_t most = 20'000;
        std::vector<double> values_;
        std::size_t next_ = 0;
    };

    std::int64_t pictures = 0;
    double seconds = 0;
    NewestValues draw_ms, input_to_picture_ms;
    /// Of a picture of another frame: the surface, from codes to colours and pixels; words, bars and curves;
    /// until fingers and these are on it, and it is shown.
    NewestValues surface_ms, words_ms, shown_ms;
    std::int64_t frames_due = 0, frames_in_time = 0;  ///< FramesShown, of all clips
    double first_picture_ms = 0;                      ///< since the window was asked for
    /// CPU time from the first picture on: of the thread that draws, of all threads of the process.
    double window_cpu_ms = 0, process_cpu_ms = 0;
    double least_detail = 1;  ///< PictureGovernor's
    double tick_late_us_p99 = 0;
    std::int64_t film_pictures = 0, film_left_out = 0;
    std::string painter, gpu, builder;  ///< gpu: that draws; empty: none
    std::string sound_fault;            ///< the first of all clips' own sound; empty: none
    std::string slow_reading;           ///< of the first clip whose pictures are read too slowly; empty: none
    std::string relief;                 ///< that was felt at the end, and what keeps it; empty: none
    std::string materials;              ///< what of those that were painted is not saved; empty: nothing
    std::int64_t ticks = 0, late_ticks = 0, frames = 0, late_frames = 0, dropped_frames = 0;
};

/// Shows a clip in a window and lets it be touched, until the person closes it. By the main thread.
Result<PlayFigures> play_in_window(PlayOptions options);

/// Whether the machine has a touch screen: an input of Linux's that lies on a display and reports several
/// fingers. `inputs`: the kernel's folder of them.
bool has_touch_screen(const std::filesystem::path& inputs = "/sys/class/input");

}  // namespace touchable
