#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "player/window/session_settings.hpp"

namespace touchable {

/// What a person finds again in the next window, whatever the clip.
struct KeptSettings {
    bool panel = false;  ///< shown
    int fingers = 1;
    int width = 0, height = 0;  ///< of the window, as `--size` has it; 0: nobody knows
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

    /// Kept nowhere.
    SettingsFile() = default;
    /// Reads what is there. What cannot be used of it is ignored and said. JSON with such members that lacks
    /// one of those that every window writes may be another program's: it is never written. What is no JSON
    /// object is set aside, as FILE.broken.
    explicit SettingsFile(std::filesystem::path file);

    const KeptSettings& read() const { return read_; }
    /// What was wrong with it; empty: nothing.
    const std::string& message() const { return message_; }
    /// Whole or not at all, and only where something is not as it was read. Refused where that cannot be;
    /// then the file is as it was.
    Result<void> write(const KeptSettings& settings) const;

private:
    void take(const std::string& text);

    std::filesystem::path file_;
    KeptSettings read_;
    std::string message_;
    bool is_foreign_ = false;  // what is there is not ours to write
};

/// play.json of this person: in $XDG_CONFIG_HOME/touchable, otherwise in ~/.config/touchable. Refused where
/// there is neither.
Result<std::filesystem::path> own_settings_file();

}  // namespace touchable
