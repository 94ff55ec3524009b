#pragma once

// Files of a person that a window uses: the clips that it shows, one after the other (Playlist), and the
// settings that last from one window to the next (SettingsFile), which the window reads when it opens and
// writes when it closes. No file of the person's is lost: settings are written whole or not at all, a file
// that cannot be used is renamed (set_aside), and one that may be another program's is left alone. An object
// belongs to the window's thread.

#include <cstddef>
#include <filesystem>

#include "engine/base/result.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/session_settings.hpp"

namespace touchable {

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

/// The settings that the next window begins with, for any clip.
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
