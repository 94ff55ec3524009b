#pragma once

// What of a touch a person can set in the window: one table of settings (metric, filters, relief, ...), which
// the panel, commands and the settings file go by, and the values that a person has set, in one set or in two
// that are compared (A and B).

#include <map>
#include <span>

#include "engine/base/result.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// A setting, and what it can be set to.
struct SessionSetting {
    const char* name;                ///< in commands and in the settings file
    const char* what = "";           ///< for a person who sees it for the first time
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
/// All settings. "filters" is before the ones that it sets together.
std::span<const SessionSetting> session_settings();
/// Null: no setting has that name.
const SessionSetting* session_setting(const std::string& name);

/// The values that a person has set in the window, by name and in words. All other settings are as the
/// command line and the clip say.
class SessionSettings {
public:
    /// "median", "5". "filters" sets all filters, and forgets what they were set to one by one. Refused
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
    std::optional<SessionSettings> b;  ///< nothing: not looked at yet
    bool b_is_on = false;

    const SessionSettings& now() const { return b_is_on ? *b : a; }
    /// Sets one of those in effect (SessionSettings::set).
    Result<void> set(const std::string& name, const std::string& value) {
        return (b_is_on ? *b : a).set(name, value);
    }
    /// The first time, B is A without filters.
    void turn_to(bool to_b);
    std::string in_words() const { return (b_is_on ? "B: " : "A: ") + now().in_words(); }
    bool operator==(const TwoSettings&) const = default;
};

/// The options of a run with these settings.
SessionOptions with_settings(SessionOptions options, const SessionSettings& settings);
/// The value of every setting but "filters" in a run, by name and in words.
std::map<std::string, std::string> settings_in_effect(const TouchSetup& setup);

/// The number that the whole word is; nothing: it is none.
std::optional<double> number_of(const std::string& word);

}  // namespace touchable
