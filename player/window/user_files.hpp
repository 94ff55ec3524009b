#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/session_settings.hpp"

namespace touchable {

// Files of a person that a window uses: the clips that it shows, the folders in which this program keeps
// things for that person, and the file of settings that lasts from one window to the next.
//
// The command line asks here for defaults (own_settings_file, own_folder) and for the clips that a word
// stands for (clips_of), and hands them to play_in_window by PlayOptions. The window asks clips_of again for
// files that are dropped on it, goes through the clips by a Playlist, reads a SettingsFile when it opens, and
// writes it when it closes.
//
// A file of the person's is never lost: settings are written whole or not at all, a file that cannot be used
// is renamed (set_aside), and one that may be another program's is left alone.
//
// All functions may be called by any thread; they read the disk and wait for it. An object belongs to one
// thread, for a window the one that runs its loop.

/// The clips that a word or a dropped file stands for. A folder that is no clip itself stands for the clips
/// in it (videos, recordings, folders with a scene file), by name, with numbers in their order: "clip2"
/// before "clip10". Any other name, and a folder without clips, stands for itself.
std::vector<std::filesystem::path> clips_of(const std::filesystem::path& named);

/// The clips of a window, and the place of one among them: the one that is shown, or on its way there.
class Playlist {
public:
    Playlist() = default;
    /// Begins with the first of `clips`. `wraps`: after the last comes the first.
    explicit Playlist(std::vector<ClipChoice> clips, bool wraps = false)
        : clips_(std::move(clips)), wraps_(wraps) {}

    std::size_t size() const { return clips_.size(); }
    std::size_t place() const { return place_; }              ///< of the clip, from 0
    const ClipChoice& now() const { return clips_[place_]; }  ///< of a list that is not empty
    /// Goes one on or back; null: there is no such clip, and the place stays.
    const ClipChoice* next();
    const ClipChoice* previous();
    const ClipChoice* go(int by) { return by > 0 ? next() : previous(); }
    /// To that place, which is there.
    void go_to(std::size_t place) { place_ = place; }

private:
    std::vector<ClipChoice> clips_;
    std::size_t place_ = 0;
    bool wraps_ = false;
};

/// This program's folder of a person: `touchable` in the folder that the environment's `variable` names,
/// else in `in_home` of the home folder. It need not exist. Fails if there is neither.
Result<std::filesystem::path> own_folder(const char* variable, const char* in_home);
/// play.json of this person: in $XDG_CONFIG_HOME/touchable, otherwise in ~/.config/touchable.
Result<std::filesystem::path> own_settings_file();

/// What a person finds again in the next window, for any clip.
struct KeptSettings {
    bool panel = false;  ///< shown
    int fingers = 1;
    int width = 0, height = 0;  ///< of the window, as `--size` has it; 0: not known
    SessionSettings a;
    std::optional<SessionSettings> b;
    bool dent = true;  ///< a surface that gives way is drawn so
    int volume = 100;  ///< of sound, 0 to 100
    bool operator==(const KeptSettings&) const = default;
};

/// The file of settings of one window, from its opening to its closing.
class SettingsFile {
public:
    static constexpr int least_width = 320, least_height = 200, most_pixels = 8192;

    /// Keeps nothing.
    SettingsFile() = default;
    /// Reads `file`. Members that cannot be used are ignored, and `message` names them. JSON with such
    /// members that lacks one of those that every window writes may be another program's: it is never
    /// written. A file that is no JSON object is set aside.
    explicit SettingsFile(std::filesystem::path file);

    const KeptSettings& read() const { return read_; }
    /// What was wrong with the file; empty: nothing.
    const std::string& message() const { return message_; }
    /// Writes the whole file, or nothing, and only if something is not as it was read. Fails if the file
    /// cannot be written; then it is as it was.
    Result<void> write(const KeptSettings& settings) const;

private:
    void take(const std::string& text);

    std::filesystem::path file_;
    KeptSettings read_;
    std::string message_;
    bool is_foreign_ = false;  // what is there is not ours to write
};

/// Renames a file that cannot be used to FILE.broken, or to FILE.broken2 and so on if such files are there:
/// the new name. A file that was set aside before stays.
Result<std::filesystem::path> set_aside(const std::filesystem::path& file);

}  // namespace touchable
