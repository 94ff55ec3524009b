#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "player/session/session_options.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// Something that a person can set about what is felt, and what it can be set to.
struct SessionSetting {
    const char* name;                ///< as commands and the settings file have it
    const char* what = "";           ///< for who sees it for the first time
    std::vector<const char*> words;  ///< what it can be; empty: a number
    double least = 0, most = 0;      ///< of a number
    bool whole = false;              ///< the number is a whole one
    const char* unit = "";           ///< of the number
    bool filter = false;             ///< one of those that `filters` sets together
    bool of_relief = false;          ///< one of those of the relief that is made of colour
    bool of_brush = false;           ///< of what a brush paints in this window; never kept
    bool of_device = false;          ///< it has an effect only where a device is held
    bool by_ratio = false;           ///< the number's slider is logarithmic
    /// Sets a legal value in the options of a run.
    void (*apply)(const std::string& value, SessionOptions& options) = nullptr;
    /// The value that a run has; null: the setting has none of its own, as "filters".
    std::string (*in_effect)(const TouchSetup& setup) = nullptr;
};
/// The one table of them. "filters" is before the ones that it sets together.
std::span<const SessionSetting> session_settings();
/// Null where there is none of that name.
const SessionSetting* session_setting(const std::string& name);

/// The values that a person has set in the window, by name and in words. Settings that are not among them are
/// as the command line and the clip say.
class SessionSettings {
public:
    /// "median", "5". "filters" sets all of them, whatever they were set to one by one. Refused
    /// (ErrorKind::usage) with what would be right.
    Result<void> set(const std::string& name, const std::string& value);
    const std::map<std::string, std::string>& values() const { return values_; }
    /// "median 5, metric pixel", or that nothing was set.
    std::string in_words() const;
    bool operator==(const SessionSettings&) const = default;

private:
    std::map<std::string, std::string> values_;
};

/// Two sets of settings to compare, of which one is in effect.
struct TwoSettings {
    SessionSettings a;
    std::optional<SessionSettings> b;  ///< nothing: nobody has looked at it yet
    bool b_is_on = false;

    const SessionSettings& now() const { return b_is_on ? *b : a; }
    /// Of those in effect, as SessionSettings has it.
    Result<void> set(const std::string& name, const std::string& value) {
        return (b_is_on ? *b : a).set(name, value);
    }
    /// Whoever looks at B for the first time finds A without filters.
    void turn_to(bool to_b);
    std::string in_words() const { return (b_is_on ? "B: " : "A: ") + now().in_words(); }
    bool operator==(const TwoSettings&) const = default;
};

/// The options of a run with these settings.
SessionOptions with_settings(SessionOptions options, const SessionSettings& settings);
/// Every setting but "filters" as a run has it, by name and in words.
std::map<std::string, std::string> settings_in_effect(const TouchSetup& setup);

/// The whole of a word; nothing where it is no number.
std::optional<double> number_of(const std::string& word);

}  // namespace touchable
