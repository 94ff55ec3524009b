#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/scene/remark.hpp"
#include "player/audio/spoken_sound.hpp"
#include "player/session/session_options.hpp"
#include "player/window/kiosk.hpp"
#include "player/window/kiosk_texts.hpp"
#include "player/window/persistent_device.hpp"
#include "player/window/playlist.hpp"
#include "player/window/screen.hpp"
#include "player/window/study.hpp"
#include "player/window/touch_labels.hpp"
#include "player/window/touch_meter.hpp"
#include "player/window/window_script.hpp"

namespace touchable {

/// What the terminal reads of a window's files and of what is guessed of its clip, as whoever started it
/// calls them.
struct PlayNames {
    std::string record = "the recording", sound = "the sound", video = "the film", screenshot = "the picture";
    std::string (*remark)(const Remark&) = remark_in_words;
    /// That a clip's materials are in `file` now, and what makes a clip of both.
    std::string (*saved)(const std::string& clip, const std::string& file) =
        [](const std::string&, const std::string& file) { return "saved as " + file; };
    /// What makes a clip of relief by these settings (settings_in_effect); empty: nobody knows.
    std::string (*relief)(const std::string& clip, const std::map<std::string, std::string>& in_effect) =
        [](const std::string&, const std::map<std::string, std::string>&) { return std::string(); };
    /// What makes a clip of it that is read faster; empty: nobody knows.
    std::string (*faster)(const std::string& clip) = [](const std::string&) { return std::string(); };
    std::string (*error)(const Error&) = [](const Error& error) { return error.message; };
};

/// A window in a public place, where nobody watches over it.
struct KioskOptions {
    KioskTimes times{};
    KioskTexts texts{};
    TouchedBy touched_by = TouchedBy::mouse;  ///< where no device is held
    bool has_bar = true;                      ///< of large buttons; not of a study
    TouchLabels labels{};                     ///< of the first clip
    /// What is said of each label, in the language of the texts; null: nothing.
    std::vector<std::shared_ptr<const SpokenSound>> label_sounds{};
    std::optional<std::filesystem::path> use_log{};  ///< UseLog; nothing: none is kept
};

/// A kiosk whose visitors are the participants of a study.
struct StudyOptions {
    Study study;
    std::filesystem::path results;  ///< a folder
};

/// A window, and what becomes of it.
struct PlayOptions {
    SessionOptions session;
    std::shared_ptr<PersistentDevice> hand{};  ///< that leads the fingers; nothing: the mouse does
    std::vector<ClipChoice> next_clips{};      ///< that come after the session's, in their order
    /// Where none of the clips can be opened, an empty window stays and says why.
    bool stays_without_clip = false;
    ScreenOptions screen;
    bool headless = false;
    std::optional<double> scale{};  ///< of words and bars; nothing: the display's
    /// That takes the place of a window, such as a test's.
    std::function<std::unique_ptr<Screen>(const ScreenOptions&)> make_screen{};
    /// What a dropped file or folder is; such as a test's, of a disk that does not answer.
    std::function<std::vector<std::filesystem::path>(const std::filesystem::path&)> clips_of =
        touchable::clips_of;
    std::optional<KioskOptions> kiosk{};  ///< it loops and keeps no settings
    std::optional<StudyOptions> study{};  ///< of a kiosk
    std::shared_ptr<TouchMeter> meter{};  ///< the window's own: measures what its study wants
    std::shared_ptr<RunGpu> gpu{};        ///< that draws; nothing: the window opens one
    std::string painter = "auto";         ///< auto, cpu, raster or mesh
    std::vector<ScriptedInput> script;
    std::optional<std::filesystem::path>
        screenshot;  ///< of what the window shows at `screenshot_s`, the last thing done
    double screenshot_s = 3;
    std::optional<double> seconds;       ///< the window closes then
    std::optional<double> most_newtons;  ///< of any finger, whatever settings are chosen
    std::optional<std::filesystem::path> record;
    std::optional<std::filesystem::path> sound;  ///< what is heard, a WAV file
    bool rumble = false;  ///< a gamepad rumbles by what is felt; not where it is `headless`
    std::optional<std::filesystem::path> video;  ///< what the window shows, a film (FilmWriter)
    Existing existing = Existing::keep;
    PlayNames names{};
    std::optional<std::filesystem::path> settings_file;  ///< nothing: nothing is kept
    std::optional<std::filesystem::path> segments;       ///< what the clip's segments are like, at first
    /// Folder in which changes by a brush last from window to window (BrushFiles); nothing: nowhere.
    std::optional<std::filesystem::path> brush_history;
    std::optional<bool> dent;     ///< whether a surface that gives way is drawn so; nothing: as it is kept
    bool size_is_stated = false;  ///< `screen` has it from a person; that of the last window does not count
    bool filters_are_stated = false;  ///< likewise by `session.clip`: kept sets A and B stay as they are
};

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

/// How it went.
struct PlayFigures {
    std::int64_t pictures = 0;
    double seconds = 0;
    NewestValues draw_ms, input_to_picture_ms;
    /// Of a picture of another frame: the surface, from codes to colours and pixels; words, bars and curves;
    /// until fingers and these are on it, and it is shown.
    NewestValues surface_ms, words_ms, shown_ms;
    std::int64_t frames_due = 0, frames_in_time = 0;  ///< FramesShown, of all clips
    double first_picture_ms = 0;                      ///< since the window was asked for
    double window_cpu_ms = 0;  ///< CPU time of the thread that draws, from the first picture on
    double least_detail = 1;   ///< PictureGovernor's
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

}  // namespace touchable
