// SPDX-License-Identifier: Apache-2.0
#pragma once

// The user's files in a window: the list of clips (Playlist), and the settings kept between windows
// (SettingsFile), which the window reads when it opens and writes when it closes. No user file is lost:
// settings are written completely or not at all, a file that cannot be used is renamed (set_aside), and a
// file of another program is left alone. An object belongs to the window's thread.

#include <cstddef>
#include <filesystem>

#include "engine/base/result.hpp"
#include "player/draw/overlays.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/session_settings.hpp"

namespace touchable {

/// A window's clips, and the position of the shown one, or of the one being opened.
class Playlist {
public:
    Playlist() = default;
    /// Begins at the first of `clips`. `wraps`: the last is followed by the first.
    explicit Playlist(std::vector<ClipChoice> clips, bool wraps = false)
        : clips_(std::move(clips)), wraps_(wraps) {}

    std::size_t size() const { return clips_.size(); }
    std::size_t place() const { return place_; }              ///< of the clip, from 0
    const ClipChoice& now() const { return clips_[place_]; }  ///< of a non-empty list
    /// Moves to the next clip, 1, or to the previous one, -1; null: there is none, and the place stays.
    const ClipChoice* go(int by);
    /// Moves to that place, which must exist.
    void go_to(std::size_t place) { place_ = place; }

private:
    std::vector<ClipChoice> clips_;
    std::size_t place_ = 0;
    bool wraps_ = false;
};

/// What a person can choose from: clips and folders.
struct FileList {
    struct Row {
        std::string words;
        std::filesystem::path path;
        bool is_folder = false;
    };
    std::filesystem::path folder;  ///< empty: no folder is listed
    std::vector<Row> rows;
    std::size_t recent = 0;  ///< rows that are recent clips, the first ones
    std::string chosen;  ///< by a dialog; empty: none was
};
/// The recent clips that still exist; then of `folder`, unless it is empty, the folder above it, its folders
/// and what is named as a clip. Waits for the disk until a stop is requested.
Result<FileList> list_files(const std::filesystem::path& folder, const std::vector<std::string>& recent);

/// The settings with which the next window begins, for any clip.
struct KeptSettings {
    bool panel = false;  ///< shown
    int fingers = 1;
    int width = 0, height = 0;  ///< of the window, in units of `--size`; 0: unknown
    SessionSettings a;
    std::optional<SessionSettings> b;
    bool dent = true;                ///< dents are drawn
    Lighting light = Lighting::off;  ///< on the clip's colours
    int volume = 100;  ///< of sound, 0 to 100
    std::vector<std::string> recent{};  ///< files of clips, newest first
    bool operator==(const KeptSettings&) const = default;
};

/// A window's settings file, from its opening to its closing.
class SettingsFile {
public:
    static constexpr std::size_t most_recent = 8;
    static constexpr int least_width = 320, least_height = 200, most_pixels = 8192;

    /// Keeps nothing.
    SettingsFile() = default;
    /// Reads `file`. Unusable members are ignored, and `message` names them. A JSON object with such members
    /// that lacks one that every window writes may be another program's: it is never written. A file that is
    /// no JSON object is set aside.
    explicit SettingsFile(std::filesystem::path file);

    const KeptSettings& read() const { return read_; }
    /// What was wrong with the file; empty: nothing.
    const std::string& message() const { return message_; }
    /// Writes the whole file, or nothing, and only if something has changed since reading. If it fails, the
    /// file is unchanged.
    Result<void> write(const KeptSettings& settings) const;

private:
    void take(const std::string& text);

    std::filesystem::path file_;
    KeptSettings read_;
    std::string message_;
    bool is_foreign_ = false;  // the file is not ours to write
};

/// Renames an unusable file to FILE.broken, or to FILE.broken2 and so on if those exist; returns the new
/// name. Files set aside earlier stay.
Result<std::filesystem::path> set_aside(const std::filesystem::path& file);

}  // namespace touchable
