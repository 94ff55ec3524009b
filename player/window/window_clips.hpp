// SPDX-License-Identifier: Apache-2.0
#pragma once

// Changes of clips and settings, prepared on a separate thread while the current clip continues. `ask_for_*`
// requests one; the newest request counts. What is ready (`take_ready`) is another clip in place of the
// current one, with its list (`replace`), or a change of it (`change`). Settings are kept as the user chose
// them, and in effect as far as the clip supports them.
//
// Runs on the window's thread. The thread that opens clips uses copies, options that no longer change, and
// WindowSound.

#include <span>

#include "player/window/clip_picture.hpp"
#include "player/window/long_work.hpp"
#include "player/window/opened_clip.hpp"
#include "player/window/user_files.hpp"

namespace touchable {

class WindowState;

/// Settings A and B as kept and as in effect (without those that the clip does not support), and the brush's
/// painted segments.
struct WindowSettings {
    TwoSettings kept, in_effect;
    std::shared_ptr<const PaintedSegments> painted{};

    /// Whether the settings in effect make painted materials felt.
    bool has_materials() const;
    /// The settings in effect, for the user.
    std::string in_words() const;
    bool operator==(const WindowSettings&) const = default;
};

/// Why a clip's session ended, or its clip broke off; nullopt: no fault.
std::optional<Error> fault_of(const OpenedClip& clip);

class WindowClips {
public:
    explicit WindowClips(WindowState& window) : window_(window) {}

    // Requests.
    void keep(const KeptSettings& kept);
    void ask_for_first();
    /// Opens the first clip that can be opened of these, including clips in folders. They, and the clips of a
    /// folder, become the list.
    void open_others(std::vector<std::string> named);
    /// Asks for a file by a dialog of the desktop, and opens it; or, without such a program or of a stated
    /// folder, by the window's own list.
    void ask_for_file(const std::string& folder);
    /// Returns whether the list was shown.
    bool close_files() {
        files_.rows.resize(files_.recent);
        return !std::exchange(files_.folder, {}).empty();
    }
    /// Opens the list's clip; if it cannot be opened, tries the others in steps of `by`; 0: no other.
    void open_instead(Playlist list, int by);
    /// Reopens the current clip.
    void open_again();
    /// Applies a settings command.
    void feel(const WindowCommand& command);
    void feel_painted(std::shared_ptr<const PaintedSegments> painted);
    /// Copies the settings in effect to the other set, without materials: one key then compares.
    void compare_with_before();
    /// Resets all settings to the defaults.
    void reset();
    /// Plays or pauses. While another clip is being opened, that one is meant; the current one shows the
    /// effect too.
    void play_or_pause();
    /// Makes the clip being opened begin by playing.
    void play_next() {
        if (next_is_paused_) next_is_paused_ = false;
    }

    // State.
    /// To choose from, now: of a folder, or recent clips in an empty window.
    FileList files() const {
        return (waits_for_wish() && !is_opening()) || !files_.folder.empty() ? files_ : FileList();
    }
    const std::vector<std::string>& recent() const { return recent_; }
    /// With the current clip.
    const Playlist& list() const { return list_; }
    /// Whether no clip was named yet.
    bool waits_for_wish() const;
    /// The list of the requested clip, or of the current one.
    const Playlist& wanted_list() const { return wanted_list_ ? *wanted_list_ : list_; }
    const WindowSettings& settings() const { return settings_; }
    /// In effect, or requested.
    const WindowSettings& wanted_settings() const { return wanted_settings_ ? *wanted_settings_ : settings_; }
    /// Whether another clip is ready, and waits only for the brush.
    bool has_next() const { return ready_ && ready_->clip; }
    bool is_opening() const { return opening_.is_busy(); }
    bool is_busy() const { return opening_.is_busy() || ready_; }
    std::string words() const { return opening_.words(); }            ///< of what is opened, or changed to
    double seconds() const { return opening_.seconds(); }             ///< since that began
    const std::optional<Error>& failure() const { return failure_; }  ///< the first of all clips

    /// A prepared result: another clip, or a change of the current one. Neither: none of the clips could be
    /// opened.
    struct Ready {
        std::unique_ptr<OpenedClip> clip{};
        std::optional<OpenedClip::Change> change{};
        WindowSettings settings{};     ///< in effect once taken
        std::string remark{};          ///< a deviation from the request, for the user
        Playlist list{};               ///< with the clip as the current one
        std::vector<Error> skipped{};  ///< why clips before it were skipped
    };
    /// Once a turn. Opens one clip after another: a held key shows each that there is time for, and finally
    /// the last. The current clip continues if another one cannot be opened, or does not support settings.
    /// Fails if the window has to close.
    Result<void> go_on();
    /// What can be taken now. `may_go`: the current clip may be replaced.
    std::optional<Ready> take_ready(bool may_go);
    /// Makes `ready`'s clip the current one, and begins it. `goes_on`: with the view of the one before.
    Result<void> replace(Ready& ready, bool goes_on);
    /// Loops or pauses the replacing clip as requested.
    void begin_playback();
    /// Changes the current clip to `ready`'s settings.
    Result<void> change(Ready& ready);
    /// Once a turn, with a clip: prepares the requested change, or a renewal of the session.
    void go_on_changing();
    /// Once a turn, with a clip.
    void note_slow_reading();

    // Shutdown.
    void let_go() {
        opening_.let_go();
        choosing_.let_go();
    }
    void give_up() {
        opening_.give_up();
        choosing_.give_up();
    }
    /// Counts the current clip's ended session, and notes its failure, or the haptic device's.
    void note_end();

private:
    Result<Ready> open_clip(ClipChoice choice, const TwoSettings& kept);
    Result<Ready> open_first(Playlist list, int by, ClipChoice choice, const TwoSettings& kept);
    void begin_asking();
    void ask_for_clip(const Playlist& list, int by, const ClipChoice& choice);
    void ask_for_named(std::vector<std::string> named);
    void ask_for_change(const WindowSettings& wanted);
    /// Drops the request for a clip.
    void forget_wish() {
        wanted_list_.reset();
        next_is_paused_.reset();
    }
    Result<void> take_made(Result<Ready> made);
    Result<void> go_on_without_clip(const Error& why);
    bool note_failure();

    WindowState& window_;
    Playlist list_;
    WindowSettings settings_;
    std::optional<WindowSettings> wanted_settings_;      // requested change
    std::optional<WindowSettings> asked_settings_;       // being prepared by `opening_`
    std::optional<Playlist> wanted_list_;                // with the requested clip as the current one
    std::optional<bool> next_is_paused_;                 // of the requested clip; nullopt: none is requested
    std::chrono::steady_clock::time_point renew_after_;  // time of the next session renewal, for more room
                                                         // for commands
    std::int64_t changed_at_ = 0;                        // PlayFigures::pictures at the last change
    std::optional<Error> failure_;
    SlowReading slow_reading_;  // of the current clip
    bool is_told_of_reading_ = false;
    std::optional<Ready> ready_;  // a change waits until the clip reaches its start
    LongWork<Ready> opening_{"clip-opening", "that opens clips"};  // ends before the data it uses
    LongWork<FileList> choosing_{"file-dialog", "that asks for a file"};
    FileList files_;
    std::vector<std::string> recent_;
};

}  // namespace touchable
