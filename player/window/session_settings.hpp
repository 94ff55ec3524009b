#pragma once

// The values that a person has set of a run in the window, by the table of settings (session_settings, in
// player/session/touch_setup.hpp), in one set or in two that are compared (A and B).

#include <map>

#include "engine/base/result.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

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

}  // namespace touchable
