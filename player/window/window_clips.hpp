#pragma once

// Clips, and other settings of one, that come and go: made ready on a thread of their own, while the clip
// that is there goes on. `ask_for_*` says what is wanted; of several wishes the newest counts. Once a turn
// `go_on` takes what is ready: another clip in place of the one that is there, with its list (show), or a
// change of it (take). Settings are kept as a person chose them, and in effect as far as the clip goes with
// them.
//
// By the window's thread. The thread that opens clips works on copies, on options that do not change any
// more, and on WindowSound.

#include <span>

#include "player/window/clip_picture.hpp"
#include "player/window/long_work.hpp"
#include "player/window/opened_clip.hpp"
#include "player/window/user_files.hpp"

namespace touchable {

class WindowCore;

/// A and B as they are kept, and as they are in effect: without what the clip would not go with; and what a
/// brush painted.
struct WindowSettings {
    TwoSettings kept, in_effect;
    std::shared_ptr<const PaintedSegments> painted{};

    /// Whether what is painted is felt by the set of settings that is in effect.
    bool has_materials() const;
    /// The set of settings that is in effect, for a person.
    std::string in_words() const;
    bool operator==(const WindowSettings&) const = default;
};

/// Why a clip's session has ended, or its clip broke off; nothing: all is well.
std::optional<Error> fault_of(const OpenedClip& clip);

class WindowClips {
public:
    explicit WindowClips(WindowCore& core) : core_(core) {}

    // What is wanted.
    void keep(const KeptSettings& kept);
    void ask_for_first();
    /// The first of these, and of the clips in folders among them, that can be opened. They, and the clips of
    /// a folder, are what there is then.
    void open_others(std::vector<std::string> named);
    /// The list's clip; where that cannot be opened, the first that can be of those `by` which the list is
    /// gone through; 0: of no other.
    void open_instead(Playlist list, int by);
    /// The clip that is there, once more.
    void open_again();
    /// A command of settings.
    void feel(const WindowCommand& command);
    void feel_painted(std::shared_ptr<const PaintedSegments> painted);
    /// The set of settings that is not in effect becomes that which is, without materials: one key compares.
    void compare_with_before();
    /// All settings are those of a window that keeps none.
    void reset();
    /// Plays or pauses. While another clip is on its way, that one is meant; the one that is there shows that
    /// the press was heard.
    void play_or_pause();
    /// The clip that is on its way begins by playing.
    void play_next() {
        if (next_is_paused_) next_is_paused_ = false;
    }

    // What there is.
    /// No clip was named yet.
    bool waits_for_wish() const;
    /// Of the clip that is asked for, or that is there.
    const Playlist& wanted_list() const;
    const WindowSettings& settings() const { return settings_; }
    /// In effect, or to be.
    const WindowSettings& wanted_settings() const { return wanted_settings_ ? *wanted_settings_ : settings_; }
    /// Whether another clip is ready, and only waits for the brush.
    bool has_next() const { return ready_ && ready_->clip; }
    bool is_opening() const { return opening_.is_busy(); }
    bool is_busy() const { return opening_.is_busy() || ready_; }
    std::string words() const { return opening_.words(); }            ///< of what is opened, or changed to
    double seconds() const { return opening_.seconds(); }             ///< since that was begun
    const std::optional<Error>& failure() const { return failure_; }  ///< the first of all clips

    /// Once a turn. One clip after the other: a key that is held shows each that there is time for, and in
    /// the end the last. The clip that is there goes on where another one cannot be opened, or it does not go
    /// with settings. Fails where the window has to close.
    Result<void> go_on();
    /// Once a turn, with a clip.
    void note_slow_reading();

    // At the end.
    void let_go() { opening_.let_go(); }
    void give_up() { opening_.give_up(); }
    /// Counts the clip that is there, whose session has ended, and notes its failure, or that of the device
    /// that is held.
    void note_end();

private:
    /// What was made ready on a thread of its own: another clip, or a change of the one that is there.
    /// Neither: none of the clips could be opened.
    struct Ready {
        std::unique_ptr<OpenedClip> clip{};
        std::optional<OpenedClip::Change> change{};
        WindowSettings settings{};     // to be in effect then
        std::string remark{};          // that something is not as it was wanted
        Playlist list{};               // in which the clip is now
        std::vector<Error> skipped{};  // why the clips before it are not open
    };

    Result<Ready> open_clip(ClipChoice choice, const TwoSettings& kept);
    Result<Ready> open_first(Playlist list, int by, ClipChoice choice, const TwoSettings& kept);
    void begin_asking();
    void ask_for_clip(const Playlist& list, int by, const ClipChoice& choice);
    void ask_for_named(std::vector<std::string> named);
    void ask_for_change(const WindowSettings& wanted);
    /// No clip is asked for any more.
    void forget_wish() {
        wanted_list_.reset();
        next_is_paused_.reset();
    }
    Result<void> take_made(Result<Ready> made);
    Result<void> go_on_without_clip(const Error& why);
    void go_on_changing();
    Result<void> take(Ready& ready);
    Result<void> show(Ready& ready);
    bool note_failure();

    WindowCore& core_;
    WindowSettings settings_;
    std::optional<WindowSettings> wanted_settings_;      // to be changed to
    std::optional<WindowSettings> asked_settings_;       // that `opening_` makes ready
    std::optional<Playlist> wanted_list_;                // of a clip that is asked for, and its place
    std::optional<bool> next_is_paused_;                 // whether it is to be; nothing: no clip is asked for
    std::chrono::steady_clock::time_point renew_after_;  // the session, by one that takes more commands
    std::int64_t changed_at_ = 0;                        // PlayFigures::pictures at the last change
    std::optional<Error> failure_;
    SlowReading slow_reading_;  // of this clip
    bool is_told_of_reading_ = false;
    std::optional<Ready> ready_;  // a change, until the clip has come to where it begins
    LongWork<Ready> opening_{"clip-opening", "that opens clips"};  // ends before what it works on
};

}  // namespace touchable
